// StudyRow is the result of a study for one candidate.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "shared/state/validity.h"
#include "slave/scene/scene.h"

namespace palpate::study {

inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

// A value and its error bar, in the same unit. NaN: unknown.
struct Estimate {
  double value = kUnknown;
  double bar = kUnknown;
};

// The result of one model for one contact: the force along the tool's direction [N].
struct Answer {
  double value = kUnknown;
  Validity validity = Validity::kFailed;
  std::string_view flag_reason;  // why it is extrapolated; may be empty
};

struct PressAnswers {
  Answer small, full;  // at the question's two depths
};

// Statement about a model's accuracy in `check` and `study`.
enum class Promise : std::uint8_t { kMeets, kMayMiss, kMisses };
// kMayMiss: the error is within the tolerance, its bound is not.
Promise OnTolerance(double error, double bound, double tolerance) noexcept;
// The promise of an update [s] at a rate [Hz].
Promise OnRate(double update, double rate) noexcept;
const char* ToString(Promise promise);  // "meets", "may miss", "MISSES"

enum class Outcome : std::uint8_t { kAnswered, kFailed, kSkipped };
const char* ToString(Outcome outcome);

// Properties of a candidate before it runs.
struct Trait {
  std::size_t number = 0;  // position among the candidates of its scene, cheapest first
  std::string family;  // models that differ in resolution only: "bem2d constant", "fem tet4 linear"
  std::string resolution;   // for people: "180 elements", "6 x 6 x 6 cells"
  double element_size = 0;  // typical edge [m]; 0: the model has no resolution
  std::size_t dof = 0;
  double expected_s = 0;   // precompute and trial together [s]
  bool own = false;        // the scene's own resolution
  bool own_model = false;  // and its own model
  // Whether a scene can have it. Others are run for the reference.
  bool selectable = true;
  bool linear = true;  // small strain and small rotation: force proportional to depth

  [[nodiscard]] std::string name() const { return family + ", " + resolution; }
};

struct StudyRow : Trait {
  ModelOptions model;          // of the candidate
  std::array<int, 3> cells{};  // of a box; 0: the object has none
  std::string kind;
  double residual = 0;  // requested residual of an iterative solver [-]; 0: none

  Outcome outcome = Outcome::kSkipped;
  std::string reason;  // why not answered, or a remark; may be empty

  std::vector<PressAnswers> answers;                           // one per contact of the study
  double precompute_s = kUnknown;                              // [s]
  double update_median_s = kUnknown, update_p99_s = kUnknown;  // a moved contact, no precompute [s]
  std::size_t memory_bytes = 0;

  // Relative error of the contact force at the full and at the small depth: the 90th percentile
  // over the contacts, for fewer than ten the largest. It is the difference from the reference, but
  // at least the reference's error bar. The bar of `error` includes that of the reference and, for
  // three or more contacts, the sampling uncertainty.
  Estimate error, error_small;
  double bound =
      kUnknown;  // error that nine of ten places do not exceed, with 95 %: BeyondBound [-]
  double plane_error = 0;                 // part of `error`: PlaneError of an outline's model [-]
  double deviation = kUnknown;            // difference from the reference at full depth [-]
  Validity validity = Validity::kFailed;  // at full depth, the worst over the contacts
  std::size_t beyond = 0;                 // contacts at which it is not valid there
  bool on_front = false;                  // no other row is both faster and more accurate
  bool meets_tolerance = false, meets_rate = false;
  bool recommended = false;
};

}  // namespace palpate::study
