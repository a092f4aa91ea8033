// The reference of a study's errors: for every contact the limit of the most trustworthy
// formulation, and its uncertainty.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// A planar object in contact with a tool, bonded or sliding, solved by a formulation that no model
// shares: quadratic finite elements on a mesh graded towards the ends of the tool, where the stress
// is singular. Force of the tool along its direction per displacement [N/m]. nullopt if the
// formulation does not apply: supports defined by element or, under a sliding tool, of one
// component; not planar, no mesh.
enum class PlanarMesh : std::uint8_t {
  kRough,   // about 2e-3, some milliseconds
  kMedium,  // 1e-3, three times as long
  kFine     // 1e-4, half a second
};
std::optional<double> PlanarStiffness(const Scene& scene, const Press& press, double width,
                                      PlanarMesh fineness);

struct Reference {
  Estimate small, full;  // force at the question's two depths, bars absolute [N]
  std::string source;    // origin of `small` and its checks
};

struct References {
  std::vector<Reference> presses;  // as in the question
  std::string remark;              // effects that the references leave out; may be empty
};

// Small depth: for planar objects and rigid tools on volumes, finite elements graded for the
// contact, if their bar is below 5 %. Otherwise the limit of each family under mesh refinement
// (Extrapolate, with every result scaled to the tool's real width by the models' own d ln force / d
// ln width), the one with the smallest error bar. That bar is extended to the difference from
// another formulation, beyond its own bar and distance to its limit. Full depth: the same, times
// the stiffening there in a large-deformation model (von Karman, neo-Hookean) relative to the small
// depth, one if none has a solution; of a membrane less what the plate's law leaves out. Round
// tools: at full depth only, by the true contact, and the large-deformation model relative to the
// linear one of the same elements. Presses that cameras see: at full depth only, by a hyperelastic
// solid.
class ReferenceFinder {
 public:
  // Solves the graded finite elements: up to a second each, coarse ones if there are more than two
  // contacts. The bar of one is the change from another mesh. The coarse ones are checked at three
  // of their positions on finer meshes, which correct all of them: the spread of the three is their
  // bar, or half of the correction.
  ReferenceFinder(const Scene& scene, const PressSpec& question);
  [[nodiscard]] References Find(const std::vector<StudyRow>& rows) const;

 private:
  void AddRound(const Scene& scene);
  [[nodiscard]] Reference FindOne(const std::vector<StudyRow>& rows, std::size_t press) const;

  PressSpec question_;
  bool is_round_;  // under a round tool
  std::optional<MembraneGeometry> membrane_;
  std::vector<Estimate> independent_;  // force at the small depth, one per contact; NaN: none
};

// How many of `count` errors at places drawn from all lie above a bound of what nine of ten of all
// places stay within. The bound holds with 95 %, whatever the distribution: that more of the places
// than these are beyond the true 90th percentile is binomial (Wilks 1941). Of fewer than 29 the
// largest is used, which holds with less.
std::size_t BeyondBound(std::size_t count);

// Fills the errors of every row that answered.
void EvaluateRows(const References& references, std::vector<StudyRow>* rows);

}  // namespace palpate::study
