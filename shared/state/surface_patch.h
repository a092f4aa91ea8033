// The local contact model as it is sent: the surface at rest around the tool, its compliance and
// its force-depth curve. The size is fixed, so that the haptic loop copies it without allocation.
// The field comments of proto/palpate/v1/patch.proto apply here too. Frame S.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include "shared/state/clock.h"

namespace palpate {

inline constexpr int kPatchVertices = 204, kPatchCells = 200, kPatchNodes = 32, kPatchTools = 5;
inline constexpr int kLawPoints = 16;

// A sphere that moves with the tool's tip.
struct PatchTool {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // from the tip [m]
  double radius = 0;                                 // [m], >= 0
};

struct SurfacePatch {
  // Square matrix of at most 96 unknowns; symmetric.
  using Compliance =
      Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, 0, 3 * kPatchNodes, 3 * kPatchNodes>;

  std::uint32_t epoch = 0;  // 0: no patch
  std::uint32_t settings_revision = 0;
  int vertex_count = 0, cell_count = 0, node_count = 0, tool_count = 1;
  int vertices_per_cell = 2;                                     // 1: the plane through vertex 0
  int directions = 3;                                            // 1: along the normal only
  bool coupled = false;                                          // off-diagonal blocks are known
  std::array<Eigen::Vector3f, kPatchVertices> vertices{};        // at rest [m]
  std::array<std::array<std::uint8_t, 3>, kPatchCells> cells{};  // vertex indices
  // Edges of the surface, a bit per corner (MarkRim).
  std::array<std::uint8_t, kPatchCells> rim{};
  std::array<std::uint8_t, kPatchVertices> node_of{};  // node of each vertex
  Compliance compliance;                               // [m/N]
  std::array<PatchTool, kPatchTools> tools{};
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  // of the plane
  double full_depth = 0, valid_depth = 0;             // [m], > 0

  [[nodiscard]] bool known() const { return epoch != 0; }
  // Returns whether it is of an unknown object: a curve along the plane, identified from estimated
  // forces.
  [[nodiscard]] bool is_learnt() const { return vertices_per_cell == 1; }
};

// Ratios of a linear surface.
inline constexpr std::array<double, kLawPoints> kLinearRatios = [] {
  std::array<double, kLawPoints> ones{};
  ones.fill(1);
  return ones;
}();

struct PatchLaw {
  std::uint32_t epoch = 0, revision = 0;
  int count = 1;
  std::array<double, kLawPoints> ratios = kLinearRatios;  // [-]
  std::optional<double> friction;                         // nullopt: the contact sticks
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();       // [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();     // [m/s]
  double velocity_error = 0;                              // [m/s]
  Time sensed_at{};                                       // slave's clock
};

}  // namespace palpate
