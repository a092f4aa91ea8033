#include "slave/mechanics/object_mesh.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"
#include "shared/validation/validation.h"
#include "slave/mechanics/mesher/fill_surface.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/mesh/index.h"
#include "slave/mesh/mesh_check.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kOffMembrane = 1e-9;  // of the radius

std::optional<double> DistanceFrom(const BoundaryMesh& mesh, const Vector3d& p_O,
                                   std::string* accepted) {
  const int element = p_O.z() == 0 ? FindElement(mesh, p_O.head<2>()) : -1;
  if (element < 0) {
    *accepted = p_O.z() == 0 ? "a finite position" : "a position in the plane z = 0";
    return std::nullopt;
  }
  const auto& found = mesh.elements[Index(element)];
  const double distance = DistanceTo(found, p_O.head<2>());
  if (distance <= 0.5 * found.length()) return distance;
  *accepted = Formatted(
      "a position on the boundary; this one is %.3g m from it, more than half an element (%.3g m)",
      distance, 0.5 * found.length());
  return std::nullopt;
}

std::optional<double> DistanceFrom(const MembraneDisc& disc, const Vector3d& p_O,
                                   std::string* accepted) {
  const double slack = kOffMembrane * disc.radius;
  if (p_O.head<2>().norm() < disc.radius && std::abs(p_O.z()) <= 0.5 * disc.thickness + slack) {
    return 0;
  }
  *accepted = Formatted("a position inside the clamped rim, radius < %.6g m and |z| <= %.3g m",
                        disc.radius, 0.5 * disc.thickness);
  return std::nullopt;
}

std::optional<double> DistanceFrom(const SurfaceMesh& surface, const Vector3d& p_O,
                                   std::string* accepted) {
  if (const auto place = FindPlace(surface, p_O)) return place->distance;
  Eigen::AlignedBox3d box;
  for (const Vector3d& node : surface.nodes) box.extend(node);
  const Vector3d &low = box.min(), &high = box.max();
  *accepted = Formatted(
      "a node, or a position at most half the longest edge of the nearest triangle from the "
      "surface; the body reaches from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g) m",
      low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
  return std::nullopt;
}

SolidMesh MeshOfFile(const MeshFileGeometry& geometry) {
  const bool unit_given = geometry.unit != 1;
  MeshFile file = ReadMesh(geometry);
  try {
    if (auto* solid = std::get_if<SolidMesh>(&file.mesh)) {
      if (geometry.resolution > 0) {
        throw std::invalid_argument(
            "object.geometry.resolution: expected with a surface; tetrahedra are taken as they "
            "are");
      }
      RequireSound(CheckMesh(*solid, file.numbers, unit_given));
      return std::move(*solid);
    }
    auto& surface = std::get<SurfaceMesh>(file.mesh);
    RequireSound(CheckMesh(surface, file.numbers, unit_given));
    if (geometry.resolution > Diagonal(surface.nodes)) {
      throw std::invalid_argument(
          "object.geometry.resolution is larger than the object: expected "
          "the edge of a tetrahedron, with its unit");
    }
    FillOptions options;
    options.resolution = geometry.resolution;
    options.numbers = file.numbers;
    return FillSurface(surface, options);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(geometry.file.string() + ": " + error.what());
  }
}

// Returns a volume with every edge halved; other meshes unchanged.
ObjectMesh Refined(const ObjectMesh& mesh) {
  if (const auto* solid = std::get_if<SolidMesh>(&mesh)) return palpate::Refined(*solid);
  return mesh;
}

// The moduli of the tetrahedra by that of the body; empty without regions.
std::vector<double> ModuliOf(const Scene& scene, const SolidMesh& mesh) {
  const std::vector<Region>& regions = scene.object.regions;
  std::vector<double> moduli;
  std::vector<char> is_used(regions.size(), 0);
  for (const auto& [a, b, c, d] : mesh.tets) {
    const Vector3d p_O = (mesh.nodes[Index(a)] + mesh.nodes[Index(b)] + mesh.nodes[Index(c)] +
                          mesh.nodes[Index(d)]) /
                         4;
    for (std::size_t i = 0; i < regions.size(); ++i) is_used[i] |= regions[i].Contains(p_O) ? 1 : 0;
    moduli.push_back(RelativeModulus(scene.object, p_O));
  }
  const auto unused = std::ranges::find(is_used, 0);
  if (unused == is_used.end()) return moduli;
  const auto i = static_cast<std::size_t>(unused - is_used.begin());
  const int line = regions[i].line;
  throw std::invalid_argument(
      (line > 0 ? scene.file.string() + ":" + std::to_string(line) + ": " : std::string()) +
      "object.regions." + std::to_string(i) +
      ": expected a part of the object that contains the centroid of a tetrahedron");
}

// Tolerance for drawn outlines, relative to the bounding box's diagonal.
constexpr double kOnSide = 1e-6;
constexpr double kNearSide = 0.03;      // the same for outlines that were measured
constexpr double kArcTolerance = 1e-9;  // [rad]

int LoopOf(const BoundaryMesh& mesh, int element) {
  int loop = 0;
  while (mesh.loop_begin[Index(loop) + 1] <= element) ++loop;
  return loop;
}

bool IsMeasured(const Geometry& geometry) {
  return std::holds_alternative<ImageContourGeometry>(geometry) ||
         std::holds_alternative<ContourFileGeometry>(geometry);
}

// Selects the elements of `fixed`. For a measured outline, a side or plane contains the elements
// near it; those of a side must also face in its direction.
class Selection {
 public:
  Selection(const Scene& scene, const BoundaryMesh& mesh)
      : mesh_(mesh), measured_(IsMeasured(scene.object.geometry)) {
    for (const auto& element : mesh.elements) box_.extend(element.a);
  }

  [[nodiscard]] bool Has(const FixedSide& side, int i) const {
    if (side.side == "rim") return LoopOf(mesh_, i) == 0;
    const bool high = side.side == "top" || side.side == "right";
    const int axis = side.side == "top" || side.side == "bottom" ? 1 : 0;
    const auto& element = Element(i);
    const double edge = (high ? box_.max() : box_.min())[axis];
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
    return std::ranges::find(nodes.nodes, i) != nodes.nodes.end();
  }

 private:
  [[nodiscard]] double near() const {
    return (measured_ ? kNearSide : kOnSide) * box_.diagonal().norm();
  }
  [[nodiscard]] const BoundaryElement& Element(int i) const { return mesh_.elements[Index(i)]; }
  const BoundaryMesh& mesh_;
  Eigen::AlignedBox2d box_;
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
                                ": expected 0 to " + std::to_string(count - 1));
  }
}

bool Holds(const Fixed& fixed, const std::vector<Vector3d>& nodes, double near, int i) {
  if (const auto* plane = std::get_if<FixedPlane>(&fixed.where)) {
    return std::abs(nodes[Index(i)][plane->axis] - plane->at) <= near;
  }
  const auto* listed = std::get_if<FixedNodes>(&fixed.where);
  return listed != nullptr && std::ranges::find(listed->nodes, i) != listed->nodes.end();
}

// Throws std::invalid_argument: no node in the plane, naming the nearest ones.
void RequireNodesIn(const Fixed& fixed, const std::vector<Vector3d>& nodes, double near) {
  const auto* plane = std::get_if<FixedPlane>(&fixed.where);
  if (plane == nullptr || nodes.empty()) return;
  const auto distance = [&](const Vector3d& p) { return std::abs(p[plane->axis] - plane->at); };
  const Vector3d& nearest = *std::ranges::min_element(nodes, {}, distance);
  if (distance(nearest) <= near) return;
  throw std::invalid_argument("object.fixed (" + Describe(fixed) + ") contains no node: " +
                              Formatted("the nearest ones are at %.6g m, %.3g m away",
                                        nearest[plane->axis], distance(nearest)));
}

// Returns the fixed components of `count` elements or nodes: object.fixed for those that `holds`
// selects. Throws if none is selected; `no` is the rest of the message.
template <std::size_t kComponents, class Holds>
std::vector<std::array<bool, kComponents>> HeldBy(const Scene& scene, int count, const char* no,
                                                  const Holds& holds) {
  std::vector<std::array<bool, kComponents>> held(Index(count));
  for (const Fixed& fixed : scene.object.fixed) {
    RequireExisting(fixed, count);
    bool any = false;
    for (int i = 0; i < count; ++i) {
      if (!holds(fixed, i)) continue;
      any = true;
      for (std::size_t c = 0; c < kComponents; ++c) {
        held[Index(i)][c] = held[Index(i)][c] || fixed.components[c];
      }
    }
    if (any) continue;
    throw std::invalid_argument("object.fixed (" + Describe(fixed) + ") contains no " + no);
  }
  return held;
}

template <std::size_t kComponents>
bool IsHeld(const std::array<bool, kComponents>& components) {
  return std::ranges::find(components, true) != components.end();
}

// Returns the nodes of edges with only one triangle.
std::vector<std::uint32_t> RimOf(const SurfaceMesh& surface) {
  std::map<std::pair<int, int>, int> triangles_at;
  for (const auto& [a, b, c] : surface.triangles) {
    for (const auto& edge : {std::minmax(a, b), std::minmax(b, c), std::minmax(c, a)}) {
      ++triangles_at[edge];
    }
  }
  std::set<std::uint32_t> rim;
  for (const auto& [edge, count] : triangles_at) {
    if (count != 1) continue;
    rim.insert({static_cast<std::uint32_t>(edge.first), static_cast<std::uint32_t>(edge.second)});
  }
  return {rim.begin(), rim.end()};
}

}  // namespace

MeshFile ReadMesh(const MeshFileGeometry& geometry) {
  if (!geometry.given) return ReadMeshFile(geometry.file, geometry.unit);
  MeshFile read{*geometry.given, {}, {}};
  std::visit(
      [&](auto& mesh) {
        for (Vector3d& node : mesh.nodes) node *= geometry.unit;
      },
      read.mesh);
  return read;
}

SurfaceMesh SurfaceOf(const ObjectMesh& mesh) {
  const auto* solid = std::get_if<SolidMesh>(&mesh);
  return solid != nullptr ? SurfaceOf(*solid) : SurfaceMesh();
}

double SizeOf(const ObjectMesh& mesh) {
  if (const auto* outline = std::get_if<BoundaryMesh>(&mesh)) return 2 * outline->length_unit;
  if (const auto* disc = std::get_if<MembraneDisc>(&mesh)) return 2 * disc->radius;
  return Diagonal(std::get<SolidMesh>(mesh).nodes);
}

TouchableSurface::TouchableSurface(const ObjectMesh& mesh) : mesh_(mesh) {
  if (const auto* solid = std::get_if<SolidMesh>(&mesh)) skin_ = SurfaceOf(*solid);
}

std::optional<double> TouchableSurface::Distance(const Vector3d& p_O, std::string* accepted) const {
  if (std::holds_alternative<SolidMesh>(mesh_)) return DistanceFrom(skin_, p_O, accepted);
  if (const auto* disc = std::get_if<MembraneDisc>(&mesh_)) {
    return DistanceFrom(*disc, p_O, accepted);
  }
  return DistanceFrom(std::get<BoundaryMesh>(mesh_), p_O, accepted);
}

BoundaryMesh MeshOutline(const Scene& scene, const std::optional<Outline>& seen) {
  const int count = scene.model.elements;
  const Geometry& geometry = scene.object.geometry;
  if (const auto* rectangle = std::get_if<RectangleGeometry>(&geometry)) {
    return MeshRectangle(rectangle->width, rectangle->height, count);
  }
  if (const auto* disc = std::get_if<DiscGeometry>(&geometry)) return MeshDisc(disc->radius, count);
  if (const auto* polygon = std::get_if<PolygonGeometry>(&geometry)) {
    return MeshPolygon(polygon->outline, count);
  }
  if (const auto* contour = std::get_if<ContourFileGeometry>(&geometry)) {
    return MeshPolygon(contour->outline, count);
  }
  if (!std::holds_alternative<ImageContourGeometry>(geometry)) {
    throw std::invalid_argument(
        "object.geometry: for an outline, expected rectangle, disc, polygon or contour");
  }
  if (seen) return MeshPolygon(*seen, count);
  throw std::invalid_argument(
      "object.geometry.contour = from-image: no outline was found in the image");
}

ObjectMesh MeshObject(const Scene& scene, const std::optional<Outline>& seen) {
  const Geometry& geometry = scene.object.geometry;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&geometry)) {
    return MembraneDisc{membrane->radius, membrane->thickness};
  }
  if (std::holds_alternative<DomeGeometry>(geometry)) {
    throw std::invalid_argument(
        "object.geometry.membrane.semi_axes: a domed membrane needs images (serve, process and "
        "their check): expected `radius`, a flat membrane");
  }
  const auto refined = [&](ObjectMesh mesh) {
    for (int r = 0; r < scene.model.refinements; ++r) mesh = Refined(mesh);
    auto* solid = std::get_if<SolidMesh>(&mesh);
    if (solid != nullptr && !scene.object.regions.empty()) solid->modulus = ModuliOf(scene, *solid);
    if (solid != nullptr) Validate(*solid, "MeshObject");
    return mesh;
  };
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) {
    return refined(MeshBox(box->size, box->cells));
  }
  if (const auto* file = std::get_if<MeshFileGeometry>(&geometry)) {
    return refined(MeshOfFile(*file));
  }
  return MeshOutline(scene, seen);
}

bool HoldsByNumber(const Scene& scene) {
  return std::ranges::any_of(scene.object.fixed, [](const Fixed& fixed) {
    return std::holds_alternative<FixedNodes>(fixed.where);
  });
}

std::vector<std::array<bool, 2>> FixedElementDofs(const Scene& scene, const BoundaryMesh& mesh) {
  const Selection selection(scene, mesh);
  return HeldBy<2>(scene, mesh.size(),
                   "element: expected a part of the outline that contains an element's midpoint",
                   [&](const Fixed& fixed, int i) {
                     return std::visit([&](const auto& where) { return selection.Has(where, i); },
                                       fixed.where);
                   });
}

HeldNodes FixedNodeDofs(const Scene& scene, const std::vector<Vector3d>& nodes) {
  const double near = kOnSide * Diagonal(nodes);
  for (const Fixed& fixed : scene.object.fixed) RequireNodesIn(fixed, nodes, near);
  return HeldBy<3>(scene, static_cast<int>(nodes.size()),
                   "node: expected a plane that contains nodes, or their numbers",
                   [&](const Fixed& fixed, int i) { return Holds(fixed, nodes, near, i); });
}

std::vector<std::uint32_t> HeldVertices(const Scene& scene, const BoundaryMesh& mesh) {
  std::set<std::uint32_t> held;
  const auto components = FixedElementDofs(scene, mesh);
  for (int i = 0; i < mesh.size(); ++i) {
    if (!IsHeld(components[Index(i)])) continue;
    held.insert({static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(mesh.Next(i))});
  }
  return {held.begin(), held.end()};
}

std::vector<std::uint32_t> HeldVertices(const Scene& scene, const SurfaceMesh& surface) {
  const Geometry& geometry = scene.object.geometry;
  if (std::holds_alternative<MembraneGeometry>(geometry) ||
      std::holds_alternative<DomeGeometry>(geometry)) {
    return RimOf(surface);
  }
  std::vector<std::uint32_t> held;
  const HeldNodes components = FixedNodeDofs(scene, surface.nodes);
  for (std::size_t i = 0; i < components.size(); ++i) {
    if (IsHeld(components[i])) held.push_back(static_cast<std::uint32_t>(i));
  }
  return held;
}

}  // namespace palpate
