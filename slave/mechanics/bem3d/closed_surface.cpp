#include "slave/mechanics/bem3d/closed_surface.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kThinnest = 1e-10;  // area / longest edge^2

[[noreturn]] void Refuse(int triangle, const std::string& why) {
  throw std::invalid_argument("triangle " + std::to_string(triangle) + ": " + why);
}

void RequireNodes(const SurfaceMesh& mesh) {
  const auto count = static_cast<int>(mesh.nodes.size());
  for (int i = 0; const auto& triangle : mesh.triangles) {
    for (const int node : triangle) {
      if (node < 0 || node >= count) {
        Refuse(i,
               "node " + std::to_string(node) + ": accepted is 0 to " + std::to_string(count - 1));
      }
      if (!mesh.nodes[Index(node)].allFinite()) {
        Refuse(i, "node " + std::to_string(node) + " is not finite");
      }
    }
    ++i;
  }
  if (mesh.triangles.size() < 4) {
    throw std::invalid_argument("a surface of " + std::to_string(mesh.triangles.size()) +
                                " triangles: accepted is 4 or more");
  }
}

void RequireArea(int i, const FlatTriangle& triangle) {
  const double longest = *std::ranges::max_element(triangle.lengths);
  if (!(triangle.area > kThinnest * longest * longest)) {
    Refuse(i, "it has no area: its corners are collinear");
  }
}

void RequireEachOnce(const SurfaceMesh& mesh) {
  std::map<std::array<int, 3>, int> seen;
  for (int i = 0; auto corners : mesh.triangles) {
    std::ranges::sort(corners);
    const auto [other, is_new] = seen.try_emplace(corners, i);
    if (!is_new) Refuse(i, "it has the corners of triangle " + std::to_string(other->second));
    ++i;
  }
}

using Edges = std::map<std::pair<int, int>, int>;  // directed edge: its triangle

Edges CollectEdges(const SurfaceMesh& mesh) {
  Edges edges;
  for (int i = 0; const auto& [a, b, c] : mesh.triangles) {
    for (const auto& edge : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
      const auto [other, is_new] = edges.try_emplace(edge, i);
      if (is_new) continue;
      Refuse(i, "it runs along the edge from node " + std::to_string(edge.first) + " to node " +
                    std::to_string(edge.second) + " in the same direction as triangle " +
                    std::to_string(other->second) +
                    ": accepted are neighbours of one orientation, two at an edge");
    }
    ++i;
  }
  return edges;
}

// The parts that hang together by edges: per triangle the first triangle of its part.
std::vector<int> FindParts(const Edges& edges, int count) {
  std::vector<int> part(Index(count));
  std::iota(part.begin(), part.end(), 0);
  const auto parent = [&](int i) -> int& { return part[Index(i)]; };
  const auto root = [&](int i) {
    while (parent(i) != i) i = parent(i) = parent(parent(i));
    return i;
  };
  for (const auto& [edge, triangle] : edges) {
    const auto other = edges.find({edge.second, edge.first});
    if (other == edges.end()) {
      Refuse(triangle, "its edge from node " + std::to_string(edge.first) + " to node " +
                           std::to_string(edge.second) +
                           " has no neighbour: accepted is a closed surface");
    }
    const int a = root(triangle), b = root(other->second);
    parent(std::max(a, b)) = std::min(a, b);
  }
  for (int i = 0; i < count; ++i) parent(i) = root(i);
  return part;
}

// Sees the part's inside under 4 pi, its outside under none.
bool IsInside(const ClosedSurface& surface, const std::vector<int>& part, int body,
              const Vector3d& x) {
  double angle = 0;
  for (std::size_t j = 0; j < part.size(); ++j) {
    if (part[j] == body) angle += SolidAngle(surface.elements[j], x);
  }
  return angle > 2 * std::numbers::pi;
}

// One part encloses the body; all others are cavities, which it encloses.
bool FindCavities(const ClosedSurface& surface, const std::vector<int>& part) {
  std::map<int, double> volumes;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const auto& t = surface.elements[i];
    volumes[part[i]] += t.area * t.normal.dot(t.centroid) / 3;
  }
  int body = -1;
  for (const auto& [first, volume] : volumes) {
    if (volume <= 0) continue;
    if (body >= 0) Refuse(first, "a second body begins here: accepted is one closed surface");
    body = first;
  }
  if (body < 0) {
    Refuse(0,
           "the surface is inside out: accepted are corners counter-clockwise seen from outside");
  }
  for (const auto& [first, volume] : volumes) {
    if (first == body) continue;
    if (!IsInside(surface, part, body, surface.elements[Index(first)].centroid)) {
      Refuse(first, "a part begins here that is inside out and is not a cavity of the body");
    }
  }
  return volumes.size() > 1;
}

// What extrapolation along one direction may add to the sum of the squared weights.
constexpr double kMostExtrapolation = 1;
// Mean square extent along a direction, of the largest: the triangles lie in a plane.
constexpr double kFlat = 1e-12;

struct Fit {
  CornerFit::Shares shares;
  bool exact = true;  // for whatever is linear in space
};

// Weights 1 / n - d_m^T S^+ d with the offsets d_m from the mean place, S = sum d_m d_m^T and the
// mean's own offset d from the node: the value of the regression there.
Fit FitAt(const Vector3d& node, const std::vector<int>& star, const ClosedSurface& surface) {
  const auto place = [&](int i) { return surface.elements[Index(i)].centroid; };
  Vector3d mean = Vector3d::Zero();
  for (const int i : star) mean += place(i) / static_cast<double>(star.size());
  Matrix3d S = Matrix3d::Zero();
  for (const int i : star) S += (place(i) - mean) * (place(i) - mean).transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(S);
  const double flat = kFlat * eigen.eigenvalues()[2];
  Fit fit;
  Vector3d slope = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const Vector3d direction = eigen.eigenvectors().col(k);
    const double extent = eigen.eigenvalues()[k];
    const double offset = direction.dot(mean - node);
    if (extent > flat && offset * offset <= kMostExtrapolation * extent) {
      slope += offset / extent * direction;
    } else if (offset * offset > flat) {
      fit.exact = false;
    }
  }
  for (const int i : star) {
    fit.shares.push_back(
        {i, 1.0 / static_cast<double>(star.size()) - (place(i) - mean).dot(slope)});
  }
  return fit;
}

}  // namespace

ClosedSurface::ClosedSurface(const SurfaceMesh& mesh) {
  RequireNodes(mesh);
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles) {
    for (const int node : triangle) box.extend(mesh.nodes[Index(node)]);
  }
  length_unit = box.sizes().maxCoeff();
  origin_O = box.center();
  if (!(length_unit > 0 && std::isfinite(length_unit))) {
    throw std::invalid_argument("a surface of size " + std::to_string(length_unit) +
                                " m: accepted is finite and > 0");
  }
  elements.reserve(mesh.triangles.size());
  for (const auto& [a, b, c] : mesh.triangles) {
    const auto p = [&](int node) -> Vector3d {
      return (mesh.nodes[Index(node)] - origin_O) / length_unit;
    };
    elements.emplace_back(p(a), p(b), p(c));
    RequireArea(size() - 1, elements.back());
  }
  RequireEachOnce(mesh);
  has_cavities = FindCavities(*this, FindParts(CollectEdges(mesh), size()));
}

CornerFit::CornerFit(const SurfaceMesh& mesh, const ClosedSurface& surface) {
  NumberCorners(mesh);
  std::vector<std::vector<int>> at(shares_.size());  // triangles by node
  std::vector<Vector3d> places(shares_.size());
  for (int i = 0; i < surface.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto node = Index(corners(i)[k]);
      at[node].push_back(i);
      places[node] = surface.elements[Index(i)].corners[k];
    }
  }
  for (std::size_t node = 0; node < at.size(); ++node) {
    Fit fit = FitAt(places[node], at[node], surface);
    if (!fit.exact) {
      std::vector<int> wider;
      for (const int i : at[node]) {
        for (const int corner : corners(i)) {
          const auto& around = at[Index(corner)];
          wider.insert(wider.end(), around.begin(), around.end());
        }
      }
      std::ranges::sort(wider);
      wider.erase(std::ranges::unique(wider).begin(), wider.end());
      fit = FitAt(places[node], wider, surface);
    }
    shares_[node] = std::move(fit.shares);
  }
}

void CornerFit::NumberCorners(const SurfaceMesh& mesh) {
  std::vector<int> number(mesh.nodes.size(), -1);
  int count = 0;
  for (const auto& triangle : mesh.triangles) {
    auto& corners = corners_.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) {
      int& node = number[Index(triangle[k])];
      if (node < 0) node = count++;
      corners[k] = node;
    }
  }
  shares_.resize(Index(count));
}

}  // namespace palpate
