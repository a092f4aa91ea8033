#include "slave/study/width_mismatch.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "shared/mesh/disc_patch.h"
#include "slave/mesh/boundary_patch.h"
#include "slave/mesh/index.h"
#include "slave/scene/model_kinds.h"
#include "slave/study/study_row.h"

namespace palpate::study {
namespace {

double PatchLength(const BoundaryMesh& mesh, const Press& press, double width) {
  const Eigen::Vector2d p = press.p_O.head<2>();
  const int element = FindElement(mesh, p);
  double length = 0;
  for (const int i : PatchElements(mesh, element, p, width)) {
    length += mesh.elements[Index(i)].length();
  }
  return length;
}

double Diameter(double area) {
  return 2 * std::sqrt(area / std::numbers::pi);
}

// Returns the diameter of the pressed nodes, each with a third of the area of the triangles around
// it.
double NodesDiameter(const SurfaceMesh& surface, const Press& press, double width) {
  const auto place = FindPlace(surface, press.p_O);
  if (!place) return kUnknown;
  const DiscPatch patch = PatchAt(surface, *place, press.p_O, width);
  const std::set<int> nodes(patch.nodes.begin(), patch.nodes.end());
  double area = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    const auto& corners = surface.triangles[Index(t)];
    const auto in_patch = std::ranges::count_if(corners, [&](int n) { return nodes.contains(n); });
    if (in_patch == 0 || Normal(surface, t).dot(press.inward_O) > -0.5) continue;
    area += Area(surface, t) * static_cast<double>(in_patch) / 3;
  }
  return Diameter(area);
}

}  // namespace

bool HasMidnodes(const ModelOptions& model) {
  const ModelKind* kind = FindModelKind(model.kind);
  return kind != nullptr && kind->has_tets && model.fem.element == FemOptions::Element::kTet10;
}

bool TakesWidthAsItIs(const ObjectMesh& mesh) {
  return std::holds_alternative<MembraneDisc>(mesh);
}

double WidthMismatch(const ObjectMesh& mesh, const ModelOptions& model, const Press& press,
                     double width) {
  if (TakesWidthAsItIs(mesh)) return 0;
  double seen = 0;
  if (const auto* boundary = std::get_if<BoundaryMesh>(&mesh)) {
    seen = PatchLength(*boundary, press, width);
  } else {
    const SurfaceMesh skin = SurfaceOf(mesh);
    seen = NodesDiameter(HasMidnodes(model) ? Refined(skin) : skin, press, width);
  }
  return seen > 0 ? seen / width - 1 : kUnknown;
}

}  // namespace palpate::study
