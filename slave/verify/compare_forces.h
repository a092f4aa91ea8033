// CompareForces compares two columns of forces: measured and estimated. It finds delay, drift,
// unit, scale, sign, exchanged axes, rotation, offset, a channel that does not change, and whether
// the stated standard deviation fits, each with an interval of 95 % and a verdict.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/verify/vector_map.h"

namespace palpate {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
inline const Eigen::Vector3d kUnknownVector3 = Eigen::Vector3d::Constant(kUnknown);

// NaN: unknown. Both forces act on the same body, in the same frame, if they are right.
struct ForceRow {
  double t = kUnknown;  // [s]
  int hold = -1;        // number of the held load; -1: row of a record
  Eigen::Vector3d measured = kUnknownVector3, estimated = kUnknownVector3;  // [N]
  double sigma = kUnknown;  // standard deviation of the difference [N]
  bool is_valid = true;
  // Position of the tip [m], and depth of the indentation [m], which is used if there are no
  // positions.
  Eigen::Vector3d p_known = kUnknownVector3, p_estimated = kUnknownVector3;
  double known_depth = kUnknown, depth = kUnknown;
};

// ForceSource is the kind of source of the estimates. It determines the meaning of sigma and the
// names of causes.
struct ForceSource {
  // kAny: sigma is that of an axis or of the vector, whichever fits. kCamera: a scene's model; its
  // sigma is that of the magnitude, and covers the tolerance of the material, so that it may be
  // larger than errors are. kFingertips: sigma is that of the vector, and covers the tolerance of
  // the material too.
  enum class Kind : std::uint8_t { kAny, kCamera, kFingertips } kind = Kind::kAny;
  double young_modulus = 0;     // modulus from which the forces were computed [Pa]; 0: none
  double pixel = 0;             // of the one camera [m]; 0: none
  std::string position_source;  // quantity that scales positions
  double object_size = 0;       // diagonal of its box [m]; 0: unknown
};

std::string_view ToString(Judgement finding);

// The verdict on one quantity. kOpen: the data do not decide it; kUntested: no data test it.
struct ComparisonLine {
  std::string key;
  std::string title;
  Judgement finding = Judgement::kUntested;
  std::optional<Interval> interval{};  // of 95 %
  std::string value{};                 // value with its interval
  std::string remark{};                // expected value, or missing data
};

struct ForceComparison {
  std::vector<ComparisonLine> lines;
  std::vector<std::string> causes;  // likely causes, one sentence each
  VectorMap map;                    // from measured to estimated forces that are divided by `unit`
  double unit = 1;                  // factor of a mistaken unit
  std::optional<VectorMap> position;
  // Errors in units of sigma, rms; and after unit, scale, drift and offset were corrected.
  double sigma_ratio = 0, corrected_sigma_ratio = 0;
  int holds = 0;          // 0: a record
  int rows = 0;           // compared under load
  int flagged = 0;        // of all rows under load with both forces
  std::vector<int> axes;  // compared

  // Throws std::out_of_range: no such line.
  [[nodiscard]] const ComparisonLine& line(std::string_view key) const;
  // Everything that was tested is right, and the magnitude was tested.
  [[nodiscard]] bool passes() const;
};

// Accepted deviations: of the scale of forces under held loads, in a record, and of positions; of
// the offset, as a share of the largest force; of directions [rad]; of the tip, as a share of the
// object's size; of drift, hysteresis and errors at one size, as a share of the largest force.
inline constexpr double kForceTolerance = 0.10, kRecordTolerance = 0.07, kPositionTolerance = 0.01,
                        kZeroTolerance = 0.03, kTurnTolerance = 0.0873, kPlaceTolerance = 0.01,
                        kChangeTolerance = 0.10;

// Rows must be in the order of time, or without time in the order of the record. An axis without
// any row in which both forces are known is not compared, and rows without a number on a compared
// axis are left out. Rows with the same hold number have correlated errors, as neighbouring rows of
// a record have. Throws std::invalid_argument: decreasing times, or only some rows have a hold
// number.
ForceComparison CompareForces(const std::vector<ForceRow>& rows, const ForceSource& source = {});

}  // namespace palpate
