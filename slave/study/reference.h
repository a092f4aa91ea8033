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
  std::string remark;              // effects that the references do not include; may be empty
};

// Small depth: for planar objects and rigid tools on volumes, finite elements graded for the
// contact, if their bar is below 5 %. Otherwise the limit of each family under mesh refinement
// (Extrapolate); the one with the smallest error bar is used. Its bar is enlarged by the difference
// from another formulation that exceeds that one's bar and distance to its limit. Full depth: the
// same, times the stiffening in a large-deformation model (von Karman, neo-Hookean) relative to the
// small depth, or one if none has a solution; for a membrane minus the error of the plate's law.
// Volumes, round tools and discs: only at full depth, with the true contact region; on a volume
// times the ratio of the large-deformation model to the linear one with the same elements. Presses
// measured by cameras: only at full depth, by a hyperelastic solid.
class ReferenceFinder {
 public:
  // Solves the graded finite elements: a second each, coarse ones if there are more than two
  // contacts. The bar of one is its stated error, on an outline the change from another mesh. The
  // coarse ones are checked at three of their positions on finer meshes, which correct all of them:
  // the spread of the three is their bar, or half of the correction.
  ReferenceFinder(const Scene& scene, const PressSpec& question);
  [[nodiscard]] References Find(const std::vector<StudyRow>& rows) const;

 private:
  void AddTouched(const Scene& scene);
  [[nodiscard]] Reference FindOne(const std::vector<StudyRow>& rows, std::size_t press) const;

  PressSpec question_;
  std::optional<MembraneGeometry> membrane_;
  std::vector<Estimate> independent_;  // force at the small depth, one per contact; NaN: none
};

// Returns how many of `count` errors at random places may lie above an upper bound of the 90th
// percentile over all places. The bound holds with 95 % confidence for any distribution: the number
// of errors beyond the true percentile is binomial (Wilks 1941). For fewer than 29 errors the
// largest is the bound, with less confidence.
std::size_t BeyondBound(std::size_t count);

// Fills the errors of every row that answered.
void EvaluateRows(const References& references, std::vector<StudyRow>* rows);

}  // namespace palpate::study
