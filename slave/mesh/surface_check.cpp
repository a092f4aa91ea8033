// Implements CheckMesh for surfaces.
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "slave/mesh/mesh_census.h"
#include "slave/mesh/mesh_check.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

struct EdgeUse {
  int triangle = 0;
  bool forward = false;  // from the smaller node to the larger
};
using EdgeMap = std::map<std::pair<int, int>, std::vector<EdgeUse>>;

EdgeMap EdgesOf(const SurfaceMesh& mesh) {
  EdgeMap edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const int a = mesh.triangles[t][i], b = mesh.triangles[t][(i + 1) % 3];
      edges[std::minmax(a, b)].push_back({static_cast<int>(t), a < b});
    }
  }
  return edges;
}

void CheckShapes(const SurfaceMesh& mesh, const MeshNumbers& numbers, MeshReport* report) {
  const double largest =
      std::max(report->low_O.cwiseAbs().maxCoeff(), report->high_O.cwiseAbs().maxCoeff());
  std::vector<double> quality;
  std::vector<int> flat;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const auto p = [&](int i) -> const Vector3d& {
      return mesh.nodes[static_cast<std::size_t>(i)];
    };
    const double longest =
        std::max({(p(b) - p(a)).norm(), (p(c) - p(b)).norm(), (p(a) - p(c)).norm()});
    const double height = longest > 0 ? ((p(b) - p(a)) / longest).cross(p(c) - p(a)).norm() : 0;
    if (!(height > kFlatElement * longest + kCoordinateRounding * largest)) {
      flat.push_back(static_cast<int>(t));
      quality.push_back(0);
      continue;
    }
    report->area += 0.5 * height * longest;
    quality.push_back(2 / std::numbers::sqrt3 * height / longest);
    report->aspect_max = std::max(report->aspect_max, longest / height);
  }
  if (!flat.empty()) {
    report->refusals.push_back(ListElements(numbers, flat) +
                               " without area: expected triangles with three corners that are "
                               "not in a line");
  }
  CountQuality(std::move(quality), numbers, report);
}

int CoincidentNodes(const SurfaceMesh& mesh) {
  std::vector<std::array<double, 3>> positions;
  for (const Vector3d& p : mesh.nodes) positions.push_back({p.x(), p.y(), p.z()});
  std::ranges::sort(positions);
  return static_cast<int>(std::ranges::unique(positions).size());
}

void CheckEdges(const SurfaceMesh& mesh, const EdgeMap& edges, const MeshNumbers& numbers,
                MeshReport* report) {
  std::string open, forked;
  for (const auto& [edge, uses] : edges) {
    const auto name = [&, ends = edge] {
      return numbers.Element(uses[0].triangle) + ", edge between " +
             ListNodes(numbers, {ends.first, ends.second});
    };
    if (uses.size() == 1 && report->open_edges++ == 0) open = name();
    if (uses.size() > 2 && report->forked_edges++ == 0) forked = name();
  }
  if (report->open_edges > 0) {
    const int coincident = CoincidentNodes(mesh);
    report->refusals.push_back(
        "the surface is open at " + std::to_string(report->open_edges) +
        " edges, the first: " + open + ": expected a closed surface" +
        (coincident == 0
             ? ""
             : "; " + std::to_string(coincident) +
                   " nodes have the position of another one: expected one node for each"));
  }
  if (report->forked_edges > 0) {
    report->refusals.push_back(std::to_string(report->forked_edges) +
                               " edges belong to three triangles or more, the first: " + forked +
                               ": expected two");
  }
}

// Finds the triangles that must be reversed so that all triangles of a part have the orientation of
// its first one. False: this is impossible (a one-sided surface).
bool FindTurned(const EdgeMap& edges, std::size_t triangles, std::vector<bool>* turned) {
  struct Neighbour {
    int triangle;
    bool against;
  };
  std::vector<std::vector<Neighbour>> neighbours(triangles);
  for (const auto& [edge, uses] : edges) {
    if (uses.size() != 2) continue;
    const bool against = uses[0].forward == uses[1].forward;
    neighbours[static_cast<std::size_t>(uses[0].triangle)].push_back({uses[1].triangle, against});
    neighbours[static_cast<std::size_t>(uses[1].triangle)].push_back({uses[0].triangle, against});
  }
  turned->assign(triangles, false);
  std::vector<bool> reached(triangles, false);
  std::vector<std::size_t> open;
  for (std::size_t seed = 0; seed < triangles; ++seed) {
    if (reached[seed]) continue;
    reached[seed] = true;
    open.push_back(seed);
    while (!open.empty()) {
      const std::size_t t = open.back();
      open.pop_back();
      for (const auto& [other, against] : neighbours[t]) {
        const auto o = static_cast<std::size_t>(other);
        const bool want = (*turned)[t] != against;
        if (reached[o] && (*turned)[o] != want) return false;
        if (reached[o]) continue;
        reached[o] = true;
        (*turned)[o] = want;
        open.push_back(o);
      }
    }
  }
  return true;
}

void Turn(SurfaceMesh* mesh, int triangle) {
  auto& t = mesh->triangles[static_cast<std::size_t>(triangle)];
  std::swap(t[1], t[2]);
}

// Orients the triangles outwards; those of a cavity point into it.
void Orient(const EdgeMap& edges, SurfaceMesh* mesh, const MeshNumbers& numbers,
            MeshReport* report) {
  std::vector<bool> turned;
  if (!FindTurned(edges, mesh->triangles.size(), &turned)) {
    report->refusals.emplace_back("the surface is one-sided: expected one that has an inside");
    return;
  }
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t]) Turn(mesh, static_cast<int>(t));
  }
  const std::vector<SurfacePart> parts = ClosedParts(*mesh);
  if (parts.empty()) {
    report->refusals.push_back("too many parts: expected at most " + std::to_string(kMaxParts));
    return;
  }
  for (const SurfacePart& part : parts) {
    const bool inward = EnclosedVolume(*mesh, part.triangles) < 0;
    if (inward == (part.depth % 2 == 1)) continue;
    for (const int t : part.triangles) {
      Turn(mesh, t);
      turned[static_cast<std::size_t>(t)] = !turned[static_cast<std::size_t>(t)];
    }
  }
  for (std::size_t t = 0; t < turned.size(); ++t) {
    if (turned[t]) report->inverted.push_back(static_cast<int>(t));
  }
  if (!report->inverted.empty()) {
    report->warnings.push_back(
        std::to_string(report->inverted.size()) +
        " triangles were turned to face outward: " + ListElements(numbers, report->inverted));
  }
  std::vector<int> all(mesh->triangles.size());
  std::iota(all.begin(), all.end(), 0);
  report->volume = EnclosedVolume(*mesh, all);
}

}  // namespace

MeshReport CheckMesh(SurfaceMesh& mesh, const MeshNumbers& numbers, bool unit_given) {
  MeshReport report;
  report.solid = false;
  report.nodes = static_cast<int>(mesh.nodes.size());
  report.elements = static_cast<int>(mesh.triangles.size());
  if (!IsReadable(mesh.nodes, mesh.triangles, numbers, &report)) return report;
  CountNodes(mesh.nodes, UsedNodes(mesh.triangles, mesh.nodes.size()), numbers, unit_given,
             &report);
  CheckShapes(mesh, numbers, &report);
  RefuseDuplicates(mesh.triangles, numbers, &report);
  PartsOf(mesh.triangles, mesh.nodes.size(), &report.parts);
  const EdgeMap edges = EdgesOf(mesh);
  CheckEdges(mesh, edges, numbers, &report);
  if (report.refusals.empty()) Orient(edges, &mesh, numbers, &report);
  return report;
}

}  // namespace palpate
