#include "slave/mechanics/make_model.h"

#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "slave/mechanics/bem/bem2d_model.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

constexpr double kDefaultRange = 0.1;   // largest |displacement| / larger side
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

std::vector<std::array<bool, 2>> HeldComponents(const Scene& scene, const BoundaryMesh& mesh) {
  std::vector<std::array<bool, 2>> held(mesh.elements.size(), {false, false});
  const Selection selection(scene, mesh);
  for (const Fixed& fixed : scene.object.fixed) {
    if (const auto* nodes = std::get_if<FixedNodes>(&fixed.where)) {
      for (const int node : nodes->nodes) {
        if (node >= 0 && node < mesh.size()) continue;
        throw std::invalid_argument("object.fixed.nodes = " + std::to_string(node) +
                                    ": accepted is 0 to " + std::to_string(mesh.size() - 1));
      }
    }
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

}  // namespace

ModelChoice ChooseModel(const Scene& scene) {
  if (scene.model.kind != "auto") return {scene.model.kind, "asked for by model.kind"};
  return {"bem2d",
          "planar outline: two-dimensional boundary elements; no study of this scene exists yet"};
}

BoundaryMesh MeshObject(const Scene& scene, const std::optional<Outline>& seen) {
  const int count = scene.model.elements;
  return std::visit(
      [&](const auto& geometry) -> BoundaryMesh {
        using G = std::decay_t<decltype(geometry)>;
        if constexpr (std::is_same_v<G, RectangleGeometry>) {
          return MeshRectangle(geometry.width, geometry.height, count);
        } else if constexpr (std::is_same_v<G, DiscGeometry>) {
          return MeshDisc(geometry.radius, count);
        } else if constexpr (std::is_same_v<G, ImageContourGeometry>) {
          if (!seen) {
            throw std::invalid_argument(
                "object.geometry.contour = from-image: no outline was found in the picture");
          }
          return MeshPolygon(*seen, count);
        } else {
          return MeshPolygon(geometry.outline, count);
        }
      },
      scene.object.geometry);
}

std::unique_ptr<DeformationModel> MakeModel(const Scene& scene, const BoundaryMesh& mesh) {
  const ModelChoice choice = ChooseModel(scene);
  if (choice.kind != "bem2d") {
    throw std::invalid_argument("model.kind = " + choice.kind + ": accepted is auto or bem2d");
  }
  if (mesh.size() < 3) {
    throw std::invalid_argument("a mesh of " + std::to_string(mesh.size()) +
                                " elements: accepted is 3 or more");
  }
  Bem2dModel::Params params;
  params.young_modulus = scene.object.material.young_modulus;
  params.thickness = ThicknessOf(scene.object.geometry);
  params.contact = scene.model.contact;
  params.range = scene.model.range > 0 ? scene.model.range : kDefaultRange;
  return std::make_unique<Bem2dModel>(
      ReferenceProblem{mesh, HeldComponents(scene, mesh), scene.object.material.poisson_ratio,
                       scene.model.plane},
      params);
}

}  // namespace palpate
