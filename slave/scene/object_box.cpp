// The object's bounding box in S.
#include <stdexcept>
#include <variant>
#include <vector>

#include "slave/mesh/files/mesh_file.h"
#include "slave/scene/sections.h"

namespace palpate {
namespace {

std::optional<BoundingBox> BoxAround(const std::vector<Eigen::Vector3d>& nodes_O,
                                     const Eigen::Isometry3d& X_SO) {
  if (nodes_O.empty()) return std::nullopt;
  BoundingBox box{X_SO * nodes_O.front(), X_SO * nodes_O.front()};
  for (const Eigen::Vector3d& p_O : nodes_O) {
    const Eigen::Vector3d p_S = X_SO * p_O;
    box.lower = box.lower.cwiseMin(p_S);
    box.upper = box.upper.cwiseMax(p_S);
  }
  return box.larger_side() > 0 ? std::optional(box) : std::nullopt;
}

std::vector<Eigen::Vector3d> Corners(const Eigen::Vector3d& lower, const Eigen::Vector3d& size) {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d share(i & 1, (i >> 1) & 1, (i >> 2) & 1);
    corners.emplace_back(lower + share.cwiseProduct(size));
  }
  return corners;
}

}  // namespace

std::optional<BoundingBox> OutlineBox(const Object& object) {
  std::vector<Eigen::Vector3d> corners;
  for (const auto& p : OutlineOf(object.geometry).outer) corners.emplace_back(p.x(), p.y(), 0);
  auto box = BoxAround(corners, object.X_SO);
  if (box) box->lower.z() = box->upper.z() = 0;
  return box;
}

std::optional<BoundingBox> SolidBox(const Object& object, const Section& scene) {
  if (IsPlanar(object.geometry) || scene.mistakes()->count() > 0) return std::nullopt;
  if (const auto* box = std::get_if<BoxGeometry>(&object.geometry)) {
    return BoxAround(Corners(Eigen::Vector3d::Zero(), box->size), object.X_SO);
  }
  if (const auto* disc = std::get_if<MembraneGeometry>(&object.geometry)) {
    const Eigen::Vector3d size(2 * disc->radius, 2 * disc->radius, disc->thickness);
    return BoxAround(Corners(-0.5 * size, size), object.X_SO);
  }
  if (const auto* dome = std::get_if<DomeGeometry>(&object.geometry)) {
    const Eigen::Vector3d side(dome->semi_axes.x(), dome->semi_axes.y(), 0);
    return BoxAround(Corners(-side, 2 * side + dome->inflation * Eigen::Vector3d::UnitZ()),
                     object.X_SO);
  }
  const auto& geometry = std::get<MeshFileGeometry>(object.geometry);
  try {
    const MeshFile file = ReadMeshFile(geometry.file, geometry.unit);
    return std::visit([&](const auto& mesh) { return BoxAround(mesh.nodes, object.X_SO); },
                      file.mesh);
  } catch (const std::invalid_argument& error) {
    scene.mistakes()->AddAtPath(*scene.node(), "object.geometry.mesh",
                                std::string("a mesh that can be read; ") + error.what());
    return std::nullopt;
  }
}

}  // namespace palpate
