// Rows of a contacts file with a round tool (contracts, `solve`, column `radius`).
#pragma once

#include <vector>

#include "slave/commands/solve/solve_rows.h"
#include "slave/mechanics/indenter/round_indenter.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/scene/scene.h"

namespace palpate {

class RoundTools {
 public:
  // Both must outlive this.
  RoundTools(const Scene& scene, const ObjectMesh& mesh) : scene_(scene), mesh_(mesh) {}

  // The row's position is the first contact of the apex; the tool's axis is the surface normal
  // there. Throws std::invalid_argument: see RoundIndenter.
  [[nodiscard]] ContactResponse Press(const SolveRow& row, DeformationModel* model,
                                      Solution* solution) const;

 private:
  [[nodiscard]] std::vector<TouchablePlace> Places() const;
  [[nodiscard]] Eigen::Vector3d NormalAt(const Eigen::Vector3d& p_O) const;

  const Scene& scene_;
  const ObjectMesh& mesh_;
};

// Throws InputError: a round tool shares its case with other rows.
void RequireAlone(const std::vector<SolveRow>& rows);

}  // namespace palpate
