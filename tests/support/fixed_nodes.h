// Selects the fixed nodes of a test's body.
#pragma once

#include "shared/mesh/solid_mesh.h"

namespace palpate {

// All components of the nodes where `is_fixed(p_O)`.
template <class Where>
HeldNodes FixedWhere(const SolidMesh& mesh, const Where& is_fixed) {
  HeldNodes held;
  for (const Eigen::Vector3d& p : mesh.nodes) {
    const bool fixed = is_fixed(p);
    held.push_back({fixed, fixed, fixed});
  }
  return held;
}

}  // namespace palpate
