// What the rows of a study are held against: for every press the force that the most trustworthy
// formulation converges to, and its own uncertainty.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// A planar object pressed by a bonded tool, solved by a formulation that no model shares: quadratic
// finite elements on a mesh graded towards the ends of the tool, where the stress is singular.
// Force of the tool along its way per displacement [N/m]; the bar is the change from a coarser
// mesh. nullopt where the formulation does not apply: frictionless contact, supports named by
// element, not planar, no mesh. About half a second, good for 1e-4; `quick`: a tenth of that, 1e-3.
std::optional<Estimate> PlanarStiffness(const Scene& scene, const Press& press, double width,
                                        bool quick = false);

struct Reference {
  Estimate small, full;  // force at the question's two depths, bars absolute [N]
  std::string source;    // where `small` comes from and what it was checked against
};

struct References {
  std::vector<Reference> presses;  // as in the question
  std::string remark;              // what they leave out; may be empty
};

// Small depth: the limit of each family under mesh refinement (Extrapolate, with every answer
// brought to the tool's real width by the models' own d ln force / d ln width) and, for planar
// objects, the independent finite element solution; the one with the smallest bar. Its bar grows to
// what it differs from another formulation beyond that one's own bar and the way to its limit.
// Full depth: the same, times how much stiffer the object is there in a large-deformation model
// (von Karman, neo-Hookean) than at the small depth; one where none answered.
class ReferenceFinder {
 public:
  // Solves the independent planar case: up to a second, quickly if there are more than two presses.
  ReferenceFinder(const Scene& scene, const PressSpec& question);
  [[nodiscard]] References Find(const std::vector<StudyRow>& rows) const;

 private:
  [[nodiscard]] Reference FindOne(const std::vector<StudyRow>& rows, std::size_t press) const;

  PressSpec question_;
  std::vector<Estimate> planar_;  // force at the small depth, one per press; NaN: none
};

// Fills the errors of every row that answered.
void JudgeRows(const References& references, std::vector<StudyRow>* rows);

}  // namespace palpate::study
