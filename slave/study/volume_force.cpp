#include "slave/study/volume_force.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "shared/mesh/disc_patch.h"
#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/mechanics/object_mesh.h"
#include "slave/mesh/index.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;
using Edge = std::pair<int, int>;
using Around = std::map<Edge, std::vector<std::size_t>>;  // the tetrahedra of each edge

constexpr std::size_t kMaxTets = 50'000;  // 100,000 take 8 GB and many minutes
constexpr std::array<std::array<std::size_t, 2>, 6> kEdges{
    {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}};

Edge EdgeOf(const SolidMesh& mesh, std::size_t tet, std::size_t edge) {
  return std::minmax({mesh.tets[tet][kEdges[edge][0]], mesh.tets[tet][kEdges[edge][1]]});
}

double Length(const SolidMesh& mesh, const Edge& edge) {
  return (mesh.nodes[Index(edge.first)] - mesh.nodes[Index(edge.second)]).norm();
}

Vector3d Middle(const SolidMesh& mesh, const Edge& edge) {
  return 0.5 * (mesh.nodes[Index(edge.first)] + mesh.nodes[Index(edge.second)]);
}

Around TetsAround(const SolidMesh& mesh) {
  Around around;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t e = 0; e < kEdges.size(); ++e) around[EdgeOf(mesh, t, e)].push_back(t);
  }
  return around;
}

Edge MaxTimeOf(const SolidMesh& mesh, std::size_t tet) {
  Edge longest{};
  double length = 0;
  for (std::size_t e = 0; e < kEdges.size(); ++e) {
    const Edge edge = EdgeOf(mesh, tet, e);
    if (Length(mesh, edge) <= length * (1 + 1e-9)) continue;
    longest = edge;
    length = Length(mesh, edge);
  }
  return longest;
}

void Bisect(const Edge& edge, const std::vector<std::size_t>& tets, SolidMesh* mesh) {
  const int middle = static_cast<int>(mesh->nodes.size());
  mesh->nodes.push_back(Middle(*mesh, edge));
  for (const std::size_t t : tets) {
    auto half = mesh->tets[t];
    std::ranges::replace(half, edge.first, middle);
    std::ranges::replace(mesh->tets[t], edge.second, middle);
    mesh->tets.push_back(half);
    if (!mesh->modulus.empty()) mesh->modulus.push_back(mesh->modulus[t]);
  }
}

// Bisects edges that are longer than `allowed`, with all tetrahedra around them. Only the longest
// edge of a tetrahedron is bisected, which preserves the element quality.
void Refine(const std::function<double(const Vector3d&)>& allowed, SolidMesh* mesh) {
  for (bool more = true; more;) {
    more = false;
    Around around = TetsAround(*mesh);
    std::set<std::pair<double, Edge>> chosen;  // the longest first
    for (const auto& [edge, tets] : around) {
      if (Length(*mesh, edge) <= allowed(Middle(*mesh, edge))) continue;
      for (const std::size_t t : tets) {
        const Edge longest = MaxTimeOf(*mesh, t);
        chosen.emplace(-Length(*mesh, longest), longest);
      }
    }
    std::vector<char> taken(mesh->tets.size(), 0);
    for (const auto& [length, edge] : chosen) {
      const auto& tets = around[edge];
      if (std::ranges::any_of(tets, [&](std::size_t t) { return taken[t] != 0; })) continue;
      for (const std::size_t t : tets) taken[t] = 1;
      Bisect(edge, tets, mesh);
      more = true;
    }
  }
}

// Width that a tool touches [m]: a flat one's own on a flat surface. A paraboloid that is as high
// as the depth at the radius r touches within r / sqrt(2). Nodes near the middle, whose height is
// uncertain, do not count.
double TouchedWidth(const SolidMesh& mesh, const Press& press, double width, double depth) {
  constexpr double kHigh = 0.25;  // of the depth
  const SurfaceMesh surface = SurfaceOf(mesh);
  double nearest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    if (Normal(surface, t).dot(press.inward_O) > -0.5) continue;
    for (const int node : surface.triangles[Index(t)]) {
      const Vector3d away = surface.nodes[Index(node)] - press.p_O;
      const double height = away.dot(press.inward_O);
      if (!(height > kHigh * depth)) continue;
      const double distance = (away - height * press.inward_O).norm();
      nearest = std::min(nearest, distance * std::sqrt(depth / height));
    }
  }
  return std::min(width, std::numbers::sqrt2 * nearest);
}

SolidMesh GradedUnder(SolidMesh mesh, const Press& press, double width, const Grading& grading) {
  Refine(
      [&](const Vector3d& p) {
        const Vector3d away = p - press.p_O;
        const double down = away.dot(press.inward_O);
        const double across = (away - down * press.inward_O).norm();
        const double from_face = away.norm() - 0.55 * width;
        const double from_rim = std::hypot(across - 0.5 * width, down);
        return std::min(std::max(grading.under * width, grading.growth * from_face),
                        grading.rim * width + grading.growth * from_rim);
      },
      &mesh);
  return mesh;
}

}  // namespace

bool HasVolumeForce(const Scene& scene) {
  return !HoldsByNumber(scene) &&
         std::holds_alternative<SolidMesh>(MeshObject(scene, std::nullopt));
}

std::optional<Estimate> VolumeForce(const Scene& scene, const Press& press, double width,
                                    double depth, const Grading& grading) {
  if (HoldsByNumber(scene)) return std::nullopt;  // new nodes between them would be free
  try {
    const Tool tool = scene.tool.value_or(Tool{.width = width});
    auto coarse = std::get<SolidMesh>(MeshObject(scene, std::nullopt));
    const double R = tool.radius;
    const double widest = IsTouchedRound(scene) ? 2 * std::sqrt(R * std::min(depth, R)) : width;
    const double touched = TouchedWidth(coarse, press, widest, depth);
    const SolidMesh mesh = GradedUnder(std::move(coarse), press, touched, grading);
    if (mesh.tets.size() > kMaxTets) return std::nullopt;
    Scene graded = scene;
    graded.model.kind = "fem-green";
    graded.model.fem.element = FemOptions::Element::kTet10;
    graded.model.fem.time = FemOptions::Time::kStatic;
    graded.model.cache.clear();
    graded.object.material.relaxation.clear();
    const auto model = MakeModel(graded, mesh);
    const auto place = FindPlace(SurfaceOf(mesh), press.p_O);
    Contact contact{.p_O = press.p_O, .width = width, .prescribed_O = depth * press.inward_O};
    contact.element = place ? place->triangle : -1;
    Solution solution;
    const ContactResponse response =
        ToolPress(graded, tool, mesh).Press(contact, model.get(), &solution);
    const double force = press.inward_O.dot(response.force_O);
    const bool known = IsForceKnown(response.validity) && force > 0 && std::isfinite(force);
    return known ? std::optional(Estimate{force, response.force_error}) : std::nullopt;
  } catch (const std::exception&) {  // this formulation is not applicable; others remain
    return std::nullopt;
  }
}

}  // namespace palpate::study
