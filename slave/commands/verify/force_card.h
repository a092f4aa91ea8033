// The verdicts of `verify` on one tool or fingertip: whether magnitude, sign, frame and sigma of
// its forces are right, and what is likely wrong.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slave/commands/verify/known_loads.h"
#include "slave/commands/verify/map_fit.h"

namespace palpate {

// `kOpen`: the loads do not decide it. `kUntested`: no load tests it.
enum class Finding : std::uint8_t { kRight, kWrong, kOpen, kUntested };
std::string_view ToString(Finding finding);

struct CardLine {
  std::string key;    // in report.json
  std::string title;  // for people
  Finding finding = Finding::kUntested;
  std::optional<Interval> interval;  // of 95 %
  std::string value;                 // with its interval, as text
  std::string remark;                // what was expected, or what is missing
};

struct ForceCard {
  std::string finger;  // empty: the only tool
  std::vector<CardLine> lines;
  std::vector<std::string> causes;  // what is likely wrong, one sentence each
  MapFit force;
  double unit = 1;  // factor by which reported forces were divided, a unit's
  std::optional<MapFit> position;
  // Errors in units of sigma, rms; of a record also after unit, scale and offset were corrected.
  double sigma_ratio = 0, corrected_sigma_ratio = 0;
  std::vector<KnownAndReported> loads;  // means under load; `sigma`: stated
  int states = 0;                       // compared under load
  int flagged = 0;                      // of all states under load with a force
  std::vector<int> axes;                // that were compared

  [[nodiscard]] const CardLine& line(std::string_view key) const;
  // Everything that was tested is right, and the force was tested.
  [[nodiscard]] bool passes() const;
};

// What the scene says about where forces come from.
struct SetUp {
  bool is_planar = false;        // forces have no z
  bool sigma_of_vector = false;  // fingertips: sigma is that of the vector, not of the magnitude
  double young_modulus = 0;      // [Pa]; 0: the force does not follow from it
  double pixel = 0;              // of the one camera [m]; 0: none
  std::string position_source;   // what scales positions, as text
  double object_size = 0;        // diagonal of its box [m]; 0: unknown, positions are relative
  bool is_record = false;        // loads are the rows of a record, in order of time
  bool has_scene = true;         // false: any source of forces; sigma may be of any kind
};

// Accepted deviation of the force's magnitude under held loads and in a record, of a position's
// scale, of the unloaded force (as a share of the largest load), and of directions [rad].
inline constexpr double kForceTolerance = 0.10, kRecordTolerance = 0.07, kPositionTolerance = 0.01,
                        kZeroTolerance = 0.03, kTurnTolerance = 0.0873;
// Accepted distance of the reported tip from the known one, as a share of the object's size.
inline constexpr double kPlaceTolerance = 0.01;
// Accepted size, as a share of the largest force, of drift during a record, of hysteresis, and of
// the mean error at forces of one size.
inline constexpr double kChangeTolerance = 0.10;

ForceCard MakeCard(const std::string& finger, const std::vector<MatchedState>& matched,
                   const SetUp& set_up);

}  // namespace palpate
