#include "slave/mesh/mesh_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numbers>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "shared/mesh/disc_patch.h"
#include "shared/text/text.h"
#include "slave/mesh/mesh_census.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

// Faces of a tetrahedron with positive volume; their normals point outwards.
constexpr std::array<std::array<std::size_t, 3>, 4> kFaces{
    {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};

struct TetShape {
  double volume = 0, longest = 0, largest_face = 0;
};

// Computes in units of `scale`, so that powers of lengths do not overflow.
TetShape ShapeOf(const SolidMesh& mesh, const std::array<int, 4>& tet, double scale) {
  std::array<Vector3d, 4> p;
  for (std::size_t i = 0; i < 4; ++i) {
    p[i] = (mesh.nodes[static_cast<std::size_t>(tet[i])] -
            mesh.nodes[static_cast<std::size_t>(tet[0])]) /
           scale;
  }
  TetShape shape;
  shape.volume = p[1].dot(p[2].cross(p[3])) / 6;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      shape.longest = std::max(shape.longest, (p[i] - p[j]).norm());
    }
  }
  for (const auto& [a, b, c] : kFaces) {
    shape.largest_face =
        std::max(shape.largest_face, 0.5 * (p[b] - p[a]).cross(p[c] - p[a]).norm());
  }
  return shape;
}

// Checks volumes, orientation and quality.
void CheckShapes(SolidMesh* mesh, const MeshNumbers& numbers, MeshReport* report) {
  const double scale = (report->high_O - report->low_O).norm();
  const double largest =
      std::max(report->low_O.cwiseAbs().maxCoeff(), report->high_O.cwiseAbs().maxCoeff()) / scale;
  std::vector<double> quality;
  std::vector<int> flat;
  double volume = 0;
  for (std::size_t t = 0; t < mesh->tets.size(); ++t) {
    auto& tet = mesh->tets[t];
    const TetShape shape = ShapeOf(*mesh, tet, scale);
    const double min_height = kFlatElement * shape.longest + kCoordinateRounding * largest;
    const double height = 3 * std::abs(shape.volume) / shape.largest_face;
    const int element = static_cast<int>(t);
    if (!(shape.largest_face > 0 && height > min_height)) {
      flat.push_back(element);
      quality.push_back(0);
      continue;
    }
    if (shape.volume < 0) {
      std::swap(tet[2], tet[3]);
      report->inverted.push_back(element);
    }
    volume += std::abs(shape.volume);
    quality.push_back(6 * std::numbers::sqrt2 * std::abs(shape.volume) /
                      std::pow(shape.longest, 3));
    report->aspect_max = std::max(report->aspect_max, shape.longest / height);
  }
  report->volume = volume * std::pow(scale, 3);
  if (!flat.empty()) {
    report->refusals.push_back(ListElements(numbers, flat) +
                               " without volume: expected tetrahedra with four corners that "
                               "are not in a plane");
  }
  CountQuality(std::move(quality), numbers, report);
}

// A face with its smallest node first, and its orientation.
struct Face {
  std::array<int, 3> sorted;
  bool even;
  int tet;
};

std::vector<Face> SortedFaces(const SolidMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tets.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const auto& [a, b, c] : kFaces) {
      std::array<int, 3> f{mesh.tets[t][a], mesh.tets[t][b], mesh.tets[t][c]};
      bool even = true;
      for (const auto& [i, j] : {std::pair{0U, 1U}, std::pair{1U, 2U}, std::pair{0U, 1U}}) {
        if (f[i] > f[j]) std::swap(f[i], f[j]), even = !even;
      }
      faces.push_back({f, even, static_cast<int>(t)});
    }
  }
  std::ranges::sort(faces, [](const Face& x, const Face& y) {
    return std::tie(x.sorted, x.tet) < std::tie(y.sorted, y.tet);
  });
  return faces;
}

// Checks that at most two tetrahedra share a face, one on each side.
void CheckFaces(const SolidMesh& mesh, const MeshNumbers& numbers, MeshReport* report) {
  const std::vector<Face> faces = SortedFaces(mesh);
  std::string crowded, folded;
  int crowded_count = 0, folded_count = 0;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i + 1;
    while (end < faces.size() && faces[end].sorted == faces[i].sorted) ++end;
    if (end - i > 2 && crowded_count++ == 0) {
      std::vector<int> tets;
      for (std::size_t k = i; k < end; ++k) tets.push_back(faces[k].tet);
      crowded = ListElements(numbers, tets);
    } else if (end - i == 2 && faces[i].even == faces[i + 1].even && folded_count++ == 0) {
      folded = ListElements(numbers, {faces[i].tet, faces[i + 1].tet});
    }
    i = end;
  }
  if (crowded_count > 0) {
    report->refusals.push_back(crowded + " share a face (" + std::to_string(crowded_count) +
                               " such): expected two at most");
  }
  if (folded_count > 0) {
    report->refusals.push_back(folded + " lie on the same side of their common face (" +
                               std::to_string(folded_count) +
                               " such): expected elements that do not overlap");
  }
}

void CheckBoundary(const SolidMesh& mesh, const MeshNumbers& numbers, MeshReport* report) {
  const SurfaceMesh surface = SurfaceOf(mesh);
  std::map<std::pair<int, int>, int> edges;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    report->area += Area(surface, static_cast<int>(t));
    const auto& tri = surface.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) ++edges[std::minmax({tri[i], tri[(i + 1) % 3]})];
  }
  std::string example;
  for (const auto& [edge, count] : edges) {
    if (count > 2 && report->forked_edges++ == 0) {
      example = ListNodes(numbers, {edge.first, edge.second});
    }
  }
  if (report->forked_edges > 0) {
    report->warnings.push_back("the body touches itself along " +
                               std::to_string(report->forked_edges) + " edges, the first between " +
                               example);
  }
}

using Eigen::Vector3d;

const Vector3d& Corner(const SurfaceMesh& surface, int triangle, std::size_t corner) {
  const int node = surface.triangles[static_cast<std::size_t>(triangle)][corner];
  return surface.nodes[static_cast<std::size_t>(node)];
}

struct Edge {
  std::pair<int, int> nodes;
  int triangle;
};

std::vector<Edge> SortedEdges(const SurfaceMesh& surface) {
  std::vector<Edge> edges;
  edges.reserve(3 * surface.triangles.size());
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const auto& nodes = surface.triangles[t];
    for (std::size_t i = 0; i < 3; ++i) {
      edges.push_back({std::minmax(nodes[i], nodes[(i + 1) % 3]), static_cast<int>(t)});
    }
  }
  std::ranges::sort(edges, {}, &Edge::nodes);
  return edges;
}

// Groups triangles that share an edge. PartsOf expects elements that share a number, so edges are
// numbered.
std::vector<SurfacePart> ByEdges(const SurfaceMesh& surface) {
  std::vector<std::array<int, 3>> edges_of(surface.triangles.size());
  std::vector<std::size_t> filled(surface.triangles.size(), 0);
  int number = -1;
  std::pair<int, int> last{-1, -1};
  for (const Edge& edge : SortedEdges(surface)) {
    if (edge.nodes != last) ++number;
    last = edge.nodes;
    const auto t = static_cast<std::size_t>(edge.triangle);
    edges_of[t][filled[t]++] = number;
  }
  int count = 0;
  const std::vector<int> part_of = PartsOf(edges_of, static_cast<std::size_t>(number + 1), &count);
  std::vector<SurfacePart> parts(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < edges_of.size(); ++t) {
    const int part = part_of[static_cast<std::size_t>(edges_of[t][0])];
    parts[static_cast<std::size_t>(part)].triangles.push_back(static_cast<int>(t));
  }
  return parts;
}

}  // namespace

MeshReport CheckMesh(SolidMesh& mesh, const MeshNumbers& numbers, bool unit_given) {
  MeshReport report;
  report.nodes = static_cast<int>(mesh.nodes.size());
  report.elements = static_cast<int>(mesh.tets.size());
  if (!IsReadable(mesh.nodes, mesh.tets, numbers, &report)) return report;
  CountNodes(mesh.nodes, UsedNodes(mesh.tets, mesh.nodes.size()), numbers, unit_given, &report);
  CheckShapes(&mesh, numbers, &report);
  RefuseDuplicates(mesh.tets, numbers, &report);
  CheckFaces(mesh, numbers, &report);
  CheckBoundary(mesh, numbers, &report);
  PartsOf(mesh.tets, mesh.nodes.size(), &report.parts);
  if (report.parts > 1) {
    report.warnings.push_back(std::to_string(report.parts) +
                              " parts that share no node: each needs a support of its own");
  }
  if (!report.inverted.empty()) {
    report.warnings.push_back(
        std::to_string(report.inverted.size()) +
        " inverted elements were turned round: " + ListElements(numbers, report.inverted));
  }
  return report;
}

std::vector<std::string> Lines(const MeshReport& r) {
  std::vector<std::string> lines;
  lines.push_back(Formatted("%d nodes, %d %s, %d part%s", r.nodes, r.elements,
                            r.solid ? "tetrahedra" : "triangles", r.parts,
                            r.parts == 1 ? "" : "s"));
  const Vector3d size = r.high_O - r.low_O;
  lines.push_back(Formatted(
      "%.6g x %.6g x %.6g m from (%.6g, %.6g, %.6g), volume %.6g m^3, surface "
      "%.6g m^2",
      size.x(), size.y(), size.z(), r.low_O.x(), r.low_O.y(), r.low_O.z(), r.volume, r.area));
  lines.push_back(Formatted("quality %.3f at least, median %.3f (1: regular), aspect %.3g at most",
                            r.quality_min, r.quality_median, r.aspect_max));
  lines.insert(lines.end(), r.warnings.begin(), r.warnings.end());
  for (const std::string& refusal : r.refusals) lines.push_back("REFUSED: " + refusal);
  return lines;
}

void RequireSound(const MeshReport& report) {
  if (!report.refusals.empty()) throw std::invalid_argument(report.refusals.front());
}

double WindingNumber(const SurfaceMesh& surface, const std::vector<int>& triangles,
                     const Vector3d& p) {
  double angle = 0;
  for (const int t : triangles) {
    // Directions only: a solid angle does not depend on lengths.
    const Vector3d a = (Corner(surface, t, 0) - p).normalized();
    const Vector3d b = (Corner(surface, t, 1) - p).normalized();
    const Vector3d c = (Corner(surface, t, 2) - p).normalized();
    angle += 2 * std::atan2(a.dot(b.cross(c)), 1 + a.dot(b) + b.dot(c) + c.dot(a));
  }
  return std::abs(angle) / (4 * std::numbers::pi);
}

double EnclosedVolume(const SurfaceMesh& surface, const std::vector<int>& triangles) {
  if (triangles.empty()) return 0;
  const Vector3d& origin = Corner(surface, triangles[0], 0);
  double volume = 0;
  for (const int t : triangles) {
    const Vector3d a = Corner(surface, t, 0) - origin, b = Corner(surface, t, 1) - origin;
    volume += a.dot(b.cross(Corner(surface, t, 2) - origin)) / 6;
  }
  return volume;
}

std::vector<SurfacePart> ClosedParts(const SurfaceMesh& surface) {
  std::vector<SurfacePart> parts = ByEdges(surface);
  if (parts.size() > kMaxParts) return {};
  for (SurfacePart& part : parts) {
    const Vector3d p = Centroid(surface, part.triangles[0]);
    for (const SurfacePart& other : parts) {
      if (&other != &part && WindingNumber(surface, other.triangles, p) > 0.5) ++part.depth;
    }
  }
  return parts;
}

}  // namespace palpate
