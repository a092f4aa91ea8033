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

// A value and how far the truth may be from it, in the same unit. NaN: not known.
struct Estimate {
  double value = kUnknown;
  double bar = kUnknown;
};

// Answer is the result of one model for one contact: the force along the tool's direction [N].
struct Answer {
  double value = kUnknown;
  Validity validity = Validity::kFailed;
  std::string_view flag_reason;  // why it is extrapolated; may be empty
  bool takes_width = false;      // see ContactResponse
};

struct PressAnswers {
  Answer small, full;             // at the question's two depths
  double width_mismatch = 0;      // WidthMismatch of the mesh there; not for loaded results [-]
  double width_slope = kUnknown;  // d ln value / d ln width as this model finds it [-]
};

enum class Outcome : std::uint8_t { kAnswered, kFailed, kSkipped };
const char* ToString(Outcome outcome);

// Properties of a candidate before it runs.
struct Trait {
  std::size_t number = 0;  // position among the candidates of its scene, cheapest first
  std::string family;  // models that differ in resolution only: "bem2d constant", "fem tet4 linear"
  std::string resolution;   // for people: "180 elements", "6 x 6 x 6 cells"
  double element_size = 0;  // typical edge [m]; 0: the model has no resolution
  std::size_t dof = 0;
  double expected_s = 0;  // precompute and trial together [s]
  bool own = false;       // the scene's own resolution
  bool linear = true;     // small strain and small rotation: force proportional to depth

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

  // Relative error of the contact force: what nine of ten contacts stay within, of fewer than ten
  // the largest. It is the distance from the reference, but at least its own bar. For
  // fewer than three contacts, at least the effect of the tool's width on the mesh, because errors
  // may cancel at one point by chance. At the full and at
  // the small depth. The bar of `error` includes the reference's own and, for three contacts and
  // more, the sampling uncertainty.
  Estimate error, error_small;
  double bound =
      kUnknown;  // error that nine of ten places do not exceed, with 95 %: BeyondBound [-]
  double deviation = kUnknown;            // the first of the three alone, at full depth [-]
  double width_error = kUnknown;          // the last of the three alone [-]
  Validity validity = Validity::kFailed;  // at full depth, the worst over the contacts
  std::size_t beyond = 0;                 // contacts at which it is not valid there
  bool on_front = false;                  // nothing is both faster and more accurate
  bool meets_tolerance = false, meets_rate = false;
  bool recommended = false;
};

}  // namespace palpate::study
