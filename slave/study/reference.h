// What the rows of a study are held against: for every press the force that the most trustworthy
// formulation converges to, and its own uncertainty.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slave/scene/scene.h"
#include "slave/study/press_spec.h"
#include "slave/study/study_row.h"

namespace palpate::study {

// A planar object pressed by a tool, bonded or sliding, solved by a formulation that no model
// shares: quadratic finite elements on a mesh graded towards the ends of the tool, where the stress
// is singular. Force of the tool along its way per displacement [N/m]. nullopt where the
// formulation does not apply: supports named by element or, under a sliding tool, of one component;
// not planar, no mesh.
enum class PlanarMesh : std::uint8_t {
  kRough,   // about 2e-3, some milliseconds
  kMedium,  // 1e-3, three times as long
  kFine     // 1e-4, half a second
};
std::optional<double> PlanarStiffness(const Scene& scene, const Press& press, double width,
                                      PlanarMesh fineness);

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
// objects and rigid tools on volumes, finite elements graded for the press; the one with the
// smallest bar. Its bar grows to
// what it differs from another formulation beyond that one's own bar and the way to its limit. Of
// three presses and more such finite elements with a bar below 5 % stand alone.
// Full depth: the same, times how much stiffer the object is there in a large-deformation model
// (von Karman, neo-Hookean) than at the small depth; one where none answered.
class ReferenceFinder {
 public:
  // Solves the graded finite elements: up to a second each, rough ones if there are more than two
  // presses. The bar of one is the change from another mesh; the rough ones are checked at three of
  // their places on finer meshes, which bring all of them nearer: how unlike the three are is their
  // bar, or half of what they differ.
  ReferenceFinder(const Scene& scene, const PressSpec& question);
  [[nodiscard]] References Find(const std::vector<StudyRow>& rows) const;

 private:
  [[nodiscard]] Reference FindOne(const std::vector<StudyRow>& rows, std::size_t press) const;

  PressSpec question_;
  std::vector<Estimate> independent_;  // force at the small depth, one per press; NaN: none
};

// Fills the errors of every row that answered.
void EvaluateRows(const References& references, std::vector<StudyRow>* rows);

}  // namespace palpate::study
