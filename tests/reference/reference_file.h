// The physics references beside the project, and the scenes' geometry built without a scene file.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/support/paths.h"

namespace palpate::reference {

using nlohmann::json;

// A file of ../shared/reference; nothing where it is absent.
inline std::optional<json> Load(const std::string& file) {
  std::ifstream stream(std::filesystem::path(SourcePath("/../shared/reference")) / file);
  if (!stream) return std::nullopt;
  return json::parse(stream);
}

inline json CaseOf(const json& file, const std::string& id) {
  for (const auto& c : file.at("cases")) {
    if (c.at("id") == id) return c;
  }
  ADD_FAILURE() << "no case " << id;
  return {};
}

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

#define PALPATE_REFERENCE_OR_SKIP(variable, file)                        \
  const auto variable##_file = palpate::reference::Load(file);           \
  if (!variable##_file) GTEST_SKIP() << "../shared/reference is absent"; \
  const auto& variable = *variable##_file
