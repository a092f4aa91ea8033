// What object.fixed holds.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/object_mesh.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kOnSide = 1e-6;        // of the bounding box's diagonal: drawn outlines
constexpr double kNearSide = 0.03;      // the same for outlines that were measured
constexpr double kArcTolerance = 1e-9;  // [rad]

struct Box {
  Vector2d low, high;
  [[nodiscard]] double diagonal() const { return (high - low).norm(); }
};

Box BoundingBox(const BoundaryMesh& mesh) {
  Box box{mesh.elements.front().a, mesh.elements.front().a};
  for (const auto& e : mesh.elements) {
    box.low = box.low.cwiseMin(e.a);
    box.high = box.high.cwiseMax(e.a);
  }
  return box;
}

int LoopOf(const BoundaryMesh& mesh, int element) {
  int loop = 0;
  while (mesh.loop_begin[static_cast<std::size_t>(loop) + 1] <= element) ++loop;
  return loop;
}

bool IsMeasured(const Geometry& geometry) {
  return std::holds_alternative<ImageContourGeometry>(geometry) ||
         std::holds_alternative<ContourFileGeometry>(geometry);
}

// Whether an element lies where `fixed` says. A measured outline's side or plane is what lies near
// it; a side also faces the way its name says.
class Selection {
 public:
  Selection(const Scene& scene, const BoundaryMesh& mesh)
      : mesh_(mesh), box_(BoundingBox(mesh)), measured_(IsMeasured(scene.object.geometry)) {}

  [[nodiscard]] bool Has(const FixedSide& side, int i) const {
    if (side.side == "rim") return LoopOf(mesh_, i) == 0;
    const bool high = side.side == "top" || side.side == "right";
    const int axis = side.side == "top" || side.side == "bottom" ? 1 : 0;
    const auto& element = Element(i);
    const double edge = (high ? box_.high : box_.low)[axis];
    const double facing = (high ? 1 : -1) * element.normal()[axis];
    return std::abs(element.midpoint()[axis] - edge) <= near() && facing > 0.5;
  }
  [[nodiscard]] bool Has(const FixedArc& arc, int i) const {
    const Vector2d p = Element(i).midpoint();
    const double off = std::remainder(std::atan2(p.y(), p.x()) - arc.centre, 2 * std::numbers::pi);
    return std::abs(off) <= arc.half_angle + kArcTolerance;
  }
  [[nodiscard]] bool Has(const FixedPlane& plane, int i) const {
    return plane.axis < 2 && std::abs(Element(i).midpoint()[plane.axis] - plane.at) <= near();
  }
  [[nodiscard]] bool Has(const FixedNodes& nodes, int i) const {
    for (const int node : nodes.nodes) {
      if (node == i) return true;
    }
    return false;
  }

 private:
  [[nodiscard]] double near() const { return (measured_ ? kNearSide : kOnSide) * box_.diagonal(); }
  [[nodiscard]] const BoundaryElement& Element(int i) const {
    return mesh_.elements[static_cast<std::size_t>(i)];
  }
  const BoundaryMesh& mesh_;
  Box box_;
  bool measured_;
};

std::string Describe(const Fixed& fixed) {
  if (const auto* side = std::get_if<FixedSide>(&fixed.where)) return "side: " + side->side;
  if (std::holds_alternative<FixedArc>(fixed.where)) return "arc";
  if (std::holds_alternative<FixedPlane>(fixed.where)) return "plane";
  return "nodes";
}

void RequireExisting(const Fixed& fixed, int count) {
  const auto* listed = std::get_if<FixedNodes>(&fixed.where);
  if (listed == nullptr) return;
  for (const int node : listed->nodes) {
    if (node >= 0 && node < count) continue;
    throw std::invalid_argument("object.fixed.nodes = " + std::to_string(node) +
                                ": accepted is 0 to " + std::to_string(count - 1));
  }
}

}  // namespace

std::vector<std::array<bool, 2>> FixedElementDofs(const Scene& scene, const BoundaryMesh& mesh) {
  std::vector<std::array<bool, 2>> held(mesh.elements.size(), {false, false});
  const Selection selection(scene, mesh);
  for (const Fixed& fixed : scene.object.fixed) {
    RequireExisting(fixed, mesh.size());
    bool any = false;
    for (int i = 0; i < mesh.size(); ++i) {
      if (!std::visit([&](const auto& where) { return selection.Has(where, i); }, fixed.where)) {
        continue;
      }
      any = true;
      auto& components = held[static_cast<std::size_t>(i)];
      components = {components[0] || fixed.components[0], components[1] || fixed.components[1]};
    }
    if (!any) {
      throw std::invalid_argument("object.fixed (" + Describe(fixed) +
                                  ") holds no element: accepted is a place on the outline that "
                                  "contains an element's midpoint");
    }
  }
  return held;
}

namespace {

bool Holds(const Fixed& fixed, const std::vector<Vector3d>& nodes, double near, std::size_t i) {
  if (const auto* plane = std::get_if<FixedPlane>(&fixed.where)) {
    return std::abs(nodes[i][plane->axis] - plane->at) <= near;
  }
  if (const auto* listed = std::get_if<FixedNodes>(&fixed.where)) {
    return std::ranges::find(listed->nodes, static_cast<int>(i)) != listed->nodes.end();
  }
  return false;
}

}  // namespace

std::vector<std::array<bool, 3>> FixedNodeDofs(const Scene& scene,
                                               const std::vector<Vector3d>& nodes) {
  std::vector<std::array<bool, 3>> held(nodes.size(), {false, false, false});
  const double near = kOnSide * Diagonal(nodes);
  for (const Fixed& fixed : scene.object.fixed) {
    RequireExisting(fixed, static_cast<int>(nodes.size()));
    bool any = false;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (!Holds(fixed, nodes, near, i)) continue;
      any = true;
      for (std::size_t c = 0; c < 3; ++c) held[i][c] = held[i][c] || fixed.components[c];
    }
    if (!any) {
      throw std::invalid_argument("object.fixed (" + Describe(fixed) +
                                  ") holds no node: accepted is a plane that contains nodes, or "
                                  "their numbers");
    }
  }
  return held;
}

}  // namespace palpate
