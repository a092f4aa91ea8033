// Names of planes and supports in the reference files.
#pragma once

#include <array>
#include <vector>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/support/references.h"

namespace palpate::reference {

inline Plane PlaneOf(const json& params) {
  return params.at("plane") == "stress" ? Plane::kStress : Plane::kStrain;
}

using Held = std::vector<std::array<bool, 2>>;

// Holds both components of the elements for which `where(midpoint)` is true.
template <typename Where>
Held HeldWhere(const BoundaryMesh& mesh, Where where) {
  Held held;
  for (const auto& e : mesh.elements) {
    const bool h = where(e.midpoint());
    held.push_back({h, h});
  }
  return held;
}

}  // namespace palpate::reference
