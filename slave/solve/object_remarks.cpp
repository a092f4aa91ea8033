#include "slave/solve/object_remarks.h"

#include <utility>
#include <variant>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "shared/text/plausible.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/mesh_check.h"
#include "slave/scene/scene_text.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Remarks = std::vector<std::string>;

// Returns the size along the axes of O.
Vector3d AddMesh(const MeshFileGeometry& geometry, Remarks* remarks) {
  MeshFile file = ReadMesh(geometry);
  const MeshReport report = std::visit(
      [&](auto& mesh) { return CheckMesh(mesh, file.numbers, geometry.unit != 1); }, file.mesh);
  const auto add = [&](const std::string& remark) {
    remarks->push_back(geometry.file.string() + ": " + remark);
  };
  for (const auto& remark : file.remarks) add(remark);
  for (const auto& warning : report.warnings) add(warning);
  return report.high_O - report.low_O;
}

// Returns the size along the axes of O; zero: not known yet.
Vector3d SizeOf(const Geometry& geometry) {
  if (const auto* box = std::get_if<BoxGeometry>(&geometry)) return box->size;
  if (const auto* disc = std::get_if<MembraneGeometry>(&geometry)) {
    return {2 * disc->radius, 2 * disc->radius, disc->thickness};
  }
  if (const auto* dome = std::get_if<DomeGeometry>(&geometry)) {
    return {2 * dome->semi_axes.x(), 2 * dome->semi_axes.y(), dome->inflation};
  }
  const auto outer = OutlineOf(geometry).outer;
  if (outer.empty()) return Vector3d::Zero();
  Eigen::AlignedBox2d box;
  for (const auto& p : outer) box.extend(p);
  return {box.sizes().x(), box.sizes().y(), 0};
}

void AddSize(const Vector3d& size, Remarks* remarks) {
  const double longest = size.maxCoeff();
  const auto is_usual = !ImplausibleRemark("object.geometry", longest, Plausible::kBodySize);
  if (!(longest > 0) || is_usual) return;
  remarks->push_back(fmt::format(
      "object.geometry is {} x {} large: {}", LengthInWords(size.x()), LengthInWords(size.y()),
      longest > 1 ? "probably millimetres; a length without a unit is in metres"
                  : "smaller than a cell; a length without a unit is in metres"));
}

void AddMaterial(const Scene& scene, Remarks* remarks) {
  const auto add = [&](const char* key, double value, Plausible kind) {
    if (auto remark = ImplausibleRemark(key, value, kind)) remarks->push_back(*std::move(remark));
  };
  const Material& material = scene.object.material;
  add("object.material.young_modulus", material.young_modulus, Plausible::kYoungModulus);
  if (material.density > 0) {
    add("object.material.density", material.density, Plausible::kDensity);
  }
  const double gravity = scene.model.fem.gravity_O.norm();
  if (gravity > 0) add("model.gravity", gravity, Plausible::kGravity);
}

}  // namespace

std::vector<std::string> RemarksOnObject(const Scene& scene) {
  Remarks remarks;
  const Geometry& geometry = scene.object.geometry;
  AddMaterial(scene, &remarks);
  Vector3d size = Vector3d::Zero();
  if (const auto* mesh = std::get_if<MeshFileGeometry>(&geometry)) {
    size = AddMesh(*mesh, &remarks);  // AddMesh has added the remark on its size
  } else {
    size = SizeOf(geometry);
    AddSize(size, &remarks);
  }
  if (size.maxCoeff() > 0 && scene.tool && scene.tool->width > size.maxCoeff()) {
    remarks.push_back(
        fmt::format("tool.width of {} is wider than the object", LengthInWords(scene.tool->width)));
  }
  return remarks;
}

}  // namespace palpate
