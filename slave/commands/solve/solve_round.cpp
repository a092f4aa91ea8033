#include "slave/commands/solve/solve_round.h"

#include <map>
#include <stdexcept>
#include <string>
#include <variant>

#include "shared/mesh/disc_patch.h"
#include "shared/text/csv.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

SurfaceMesh SurfaceOfObject(const ObjectMesh& mesh) {
  SurfaceMesh surface = SurfaceOf(mesh);
  if (!surface.triangles.empty()) return surface;
  throw std::invalid_argument("radius: expected a planar object or a volume under a round tool");
}

}  // namespace

std::vector<TouchablePlace> RoundTools::Places() const {
  if (const auto* outline = std::get_if<BoundaryMesh>(&mesh_)) return TouchablePlaces(*outline);
  return TouchableNodes(SurfaceOfObject(mesh_));
}

Eigen::Vector3d RoundTools::NormalAt(const Eigen::Vector3d& p_O) const {
  if (const auto* outline = std::get_if<BoundaryMesh>(&mesh_)) {
    const int element = FindElement(*outline, p_O.head<2>());
    if (element < 0) return Eigen::Vector3d::Zero();
    const Eigen::Vector2d n = outline->elements[Index(element)].normal();
    return {n.x(), n.y(), 0};
  }
  const SurfaceMesh surface = SurfaceOfObject(mesh_);
  const auto place = FindPlace(surface, p_O);
  return place ? Normal(surface, place->triangle) : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

ContactResponse RoundTools::Press(const SolveRow& row, DeformationModel* model,
                                  Solution* solution) const {
  const Contact& contact = row.contact;
  const Eigen::Vector3d n = NormalAt(contact.p_O);
  if (n.isZero(0)) return {};
  RoundIndenter tool(Places(), row.radius, scene_.model.contact);
  return tool.Press({contact.p_O, n, contact.prescribed_O}, model, solution);
}

void RequireAlone(const std::vector<SolveRow>& rows) {
  std::map<std::string, int> rows_of;
  for (const SolveRow& row : rows) ++rows_of[row.case_name];
  for (const SolveRow& row : rows) {
    if (row.radius > 0 && rows_of[row.case_name] > 1) {
      throw InputError("solve: case " + row.case_name +
                       ": a round tool together with other rows: expected a separate case");
    }
  }
}

}  // namespace palpate
