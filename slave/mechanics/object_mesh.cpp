#include "slave/mechanics/object_mesh.h"

#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "shared/mesh/boundary_patch.h"
#include "shared/mesh/files/mesh_file.h"
#include "shared/mesh/mesh_check.h"
#include "shared/mesh/surface_patch.h"
#include "slave/mechanics/mesher/fill_surface.h"
#include "slave/scene/model_kinds.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kOffMembrane = 1e-9;  // of the radius

std::string Words(const char* format, double a, double b) {
  std::array<char, 200> text{};
  std::snprintf(text.data(), text.size(), format, a, b);
  return text.data();
}

std::optional<std::string> RefuseAt(const BoundaryMesh& mesh, const Vector3d& p_O) {
  if (p_O.z() != 0) return "a place in the plane z = 0";
  const int element = FindElement(mesh, p_O.head<2>());
  if (element < 0) return "a finite place";
  const auto& found = mesh.elements[static_cast<std::size_t>(element)];
  const double distance = DistanceTo(found, p_O.head<2>());
  if (distance <= 0.5 * found.length()) return std::nullopt;
  return Words(
      "a place on the boundary; this one lies %.3g m from it, more than half an element (%.3g m)",
      distance, 0.5 * found.length());
}

std::optional<std::string> RefuseAt(const MembraneDisc& disc, const Vector3d& p_O) {
  const double slack = kOffMembrane * disc.radius;
  if (p_O.head<2>().norm() < disc.radius && std::abs(p_O.z()) <= 0.5 * disc.thickness + slack) {
    return std::nullopt;
  }
  return Words("a place inside the clamped rim, radius < %.6g m and |z| <= %.3g m", disc.radius,
               0.5 * disc.thickness);
}

std::optional<std::string> RefuseAt(const SurfaceMesh& surface, const Vector3d& p_O) {
  if (FindPlace(surface, p_O)) return std::nullopt;
  return "a node, or a place on the surface, half the longest edge of the nearest triangle from it "
         "at most";
}

ObjectMesh MeshOfFile(const MeshFileGeometry& geometry, const ModelKind* kind) {
  const bool unit_given = geometry.unit != 1;
  MeshFile file = ReadMeshFile(geometry.file, geometry.unit);
  try {
    if (auto* solid = std::get_if<SolidMesh>(&file.mesh)) {
      RequireSound(CheckMesh(*solid, file.numbers, unit_given));
      return std::move(*solid);
    }
    auto& surface = std::get<SurfaceMesh>(file.mesh);
    RequireSound(CheckMesh(surface, file.numbers, unit_given));
    if (kind != nullptr && kind->on_surface) return std::move(surface);
    if (geometry.resolution > Diagonal(surface.nodes)) {
      throw std::invalid_argument(
          "object.geometry.resolution is larger than the object: accepted "
          "is the edge of a tetrahedron, with its unit");
    }
    FillOptions options;
    options.resolution = geometry.resolution;
    options.numbers = file.numbers;
    return FillSurface(surface, options);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(geometry.file.string() + ": " + error.what());
  }
}

}  // namespace

TouchableSurface::TouchableSurface(const ObjectMesh& mesh) : mesh_(mesh) {
  if (const auto* solid = std::get_if<SolidMesh>(&mesh)) skin_ = SurfaceOf(*solid);
}

std::optional<std::string> TouchableSurface::Refuse(const Vector3d& p_O) const {
  if (std::holds_alternative<SolidMesh>(mesh_)) return RefuseAt(skin_, p_O);
  if (const auto* surface = std::get_if<SurfaceMesh>(&mesh_)) return RefuseAt(*surface, p_O);
  if (const auto* disc = std::get_if<MembraneDisc>(&mesh_)) return RefuseAt(*disc, p_O);
  return RefuseAt(std::get<BoundaryMesh>(mesh_), p_O);
}

BoundaryMesh MeshOutline(const Scene& scene, const std::optional<Outline>& seen) {
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
        } else if constexpr (std::is_same_v<G, PolygonGeometry> ||
                             std::is_same_v<G, ContourFileGeometry>) {
          return MeshPolygon(geometry.outline, count);
        } else {
          throw std::invalid_argument(
              "object.geometry: accepted where an outline is needed is a planar one: rectangle, "
              "disc, polygon or contour");
        }
      },
      scene.object.geometry);
}

ObjectMesh MeshObject(const Scene& scene, const std::optional<Outline>& seen) {
  const Geometry& geometry = scene.object.geometry;
  if (const auto* membrane = std::get_if<MembraneGeometry>(&geometry)) {
    return MembraneDisc{membrane->radius, membrane->thickness};
  }
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) return MeshBox(box->size, box->cells);
  if (const auto* file = std::get_if<MeshFileGeometry>(&geometry)) {
    return MeshOfFile(*file, FindModelKind(scene.model.kind));
  }
  return MeshOutline(scene, seen);
}

}  // namespace palpate
