#include "slave/commands/solve/field_file.h"

#include <stdexcept>
#include <variant>

#include "slave/commands/solve/nodal_field_file.h"
#include "slave/commands/solve/planar_field_file.h"
#include "slave/mechanics/plate/membrane_grid.h"

namespace palpate {
namespace {

// The triangles' centroids, where bem3d knows the displacement.
VtuGrid CentroidsOf(const SurfaceMesh& surface) {
  VtuGrid grid;
  for (const auto& [a, b, c] : surface.triangles) {
    const auto p = [&](int i) { return surface.nodes[static_cast<std::size_t>(i)]; };
    grid.vertices.push_back(static_cast<int>(grid.points.size()));
    grid.points.emplace_back((p(a) + p(b) + p(c)) / 3);
  }
  return grid;
}

VtuGrid GridFor(const std::string& kind, const ObjectMesh& mesh) {
  if (const auto* disc = std::get_if<MembraneDisc>(&mesh))
    return GridOf(MembraneGrid(disc->radius));
  if (const auto* surface = std::get_if<SurfaceMesh>(&mesh)) return CentroidsOf(*surface);
  const auto& solid = std::get<SolidMesh>(mesh);
  return kind == "bem3d" ? CentroidsOf(SurfaceOf(solid)) : GridOf(solid);
}

}  // namespace

std::unique_ptr<FieldFile> MakeFieldFile(const std::filesystem::path& file, DeformationModel& model,
                                         const ObjectMesh& mesh) {
  if (const auto* planar = dynamic_cast<const Bem2dModel*>(&model)) {
    return std::make_unique<PlanarFieldFile>(file, *planar);
  }
  return std::make_unique<NodalFieldFile>(file, model, GridFor(model.info().kind, mesh));
}

}  // namespace palpate
