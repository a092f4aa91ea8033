// What the references call a plane and a hold, and the scenes' geometry built without a scene file.
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

// Both components held where `where(midpoint)` says so.
template <typename Where>
Held HeldWhere(const BoundaryMesh& mesh, Where where) {
  Held held;
  for (const auto& e : mesh.elements) {
    const bool h = where(e.midpoint());
    held.push_back({h, h});
  }
  return held;
}

// Several polygons as one mesh, holes given clockwise.
inline BoundaryMesh MeshOf(const std::vector<std::vector<Eigen::Vector2d>>& loops, double unit) {
  BoundaryMesh mesh;
  mesh.length_unit = unit;
  mesh.loop_begin.push_back(0);
  for (const auto& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      mesh.elements.push_back({loop[i], loop[(i + 1) % loop.size()]});
    }
    mesh.loop_begin.push_back(mesh.size());
  }
  return mesh;
}

}  // namespace palpate::reference
