// Divides outlines into boundary elements.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

#include <Eigen/Geometry>

#include "slave/mesh/outline.h"

namespace palpate {
namespace {

using Loop = std::vector<Eigen::Vector2d>;

void RequireSize(const char* name, double value) {
  if (!(value > 0 && std::isfinite(value))) {
    throw std::invalid_argument(std::string(name) + " = " + std::to_string(value) +
                                ": expected a finite length > 0");
  }
}

void RequireCount(int count, int least) {
  if (count < least) {
    throw std::invalid_argument("elements = " + std::to_string(count) + ": expected " +
                                std::to_string(least) + " or more");
  }
}

// Distributes the remainder after rounding down to the largest fractions; equal ones (to rounding,
// so that opposite sides of a rectangle are equal) in order.
std::vector<int> LargestRemainder(const std::vector<double>& quota, int count) {
  std::vector<int> shares;
  shares.reserve(quota.size());
  std::vector<std::size_t> order(quota.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<long long> fraction;  // in units of 1e-9
  for (const double q : quota) {
    const double whole = std::floor(q);
    shares.push_back(static_cast<int>(whole));
    fraction.push_back(std::llround((q - whole) * 1e9));
  }
  std::ranges::stable_sort(order, [&](auto i, auto j) { return fraction[i] > fraction[j]; });
  int left = count - std::accumulate(shares.begin(), shares.end(), 0);
  for (std::size_t k = 0; left > 0; k = (k + 1) % order.size(), --left) ++shares[order[k]];
  return shares;
}

// Distributes `count` elements over edges in proportion to their lengths. Edges that are too short
// for one get one, and the others share the rest.
std::vector<int> ShareByLength(const std::vector<double>& lengths, int count) {
  std::vector<int> shares(lengths.size(), 1);
  std::vector<std::size_t> sharing(lengths.size());
  std::iota(sharing.begin(), sharing.end(), std::size_t{0});
  int rest = count;
  for (;;) {
    double total = 0;
    for (const std::size_t i : sharing) total += lengths[i];
    const auto too_short = [&](std::size_t i) { return lengths[i] / total * rest < 1 - 1e-9; };
    const auto removed = std::erase_if(sharing, too_short);
    rest -= static_cast<int>(removed);
    if (removed > 0 && !sharing.empty()) continue;
    std::vector<double> quota;
    quota.reserve(sharing.size());
    for (const std::size_t i : sharing) quota.push_back(lengths[i] / total * rest);
    const std::vector<int> parts = LargestRemainder(quota, rest);
    for (std::size_t k = 0; k < sharing.size(); ++k) shares[sharing[k]] = parts[k];
    return shares;
  }
}

std::vector<double> EdgeLengths(const std::vector<Loop>& loops) {
  std::vector<double> lengths;
  for (const auto& loop : loops) {
    for (std::size_t i = 0; i < loop.size(); ++i) {
      lengths.push_back((loop[(i + 1) % loop.size()] - loop[i]).stableNorm());
    }
  }
  return lengths;
}

void DivideEdge(const Eigen::Vector2d& a, const Eigen::Vector2d& b, int parts, BoundaryMesh* mesh) {
  const auto node = [&](int k) -> Eigen::Vector2d {
    return k == parts ? b : a + (b - a) * (static_cast<double>(k) / parts);
  };
  for (int k = 0; k < parts; ++k) mesh->elements.push_back({node(k), node(k + 1)});
}

double LargerSide(const Loop& loop) {
  Eigen::AlignedBox2d box;
  for (const auto& p : loop) box.extend(p);
  return box.sizes().maxCoeff();
}

BoundaryMesh MeshLoops(const std::vector<Loop>& loops, int count) {
  const std::vector<double> lengths = EdgeLengths(loops);
  const std::vector<int> parts =
      ShareByLength(lengths, std::max(count, static_cast<int>(lengths.size())));
  BoundaryMesh mesh;
  mesh.length_unit = LargerSide(loops[0]);
  std::size_t edge = 0;
  for (const auto& loop : loops) {
    mesh.loop_begin.push_back(mesh.size());
    for (std::size_t i = 0; i < loop.size(); ++i) {
      DivideEdge(loop[i], loop[(i + 1) % loop.size()], parts[edge++], &mesh);
    }
  }
  mesh.loop_begin.push_back(mesh.size());
  return mesh;
}

// Returns the loop in the requested orientation with the same first point.
Loop Turned(Loop loop, bool counter_clockwise) {
  if ((SignedArea(loop) > 0) != counter_clockwise) std::reverse(loop.begin() + 1, loop.end());
  return loop;
}

}  // namespace

BoundaryMesh MeshRectangle(double width, double height, int count) {
  RequireSize("width", width);
  RequireSize("height", height);
  RequireCount(count, 4);
  return MeshLoops({{{0, 0}, {width, 0}, {width, height}, {0, height}}}, count);
}

BoundaryMesh MeshDisc(double radius, int count) {
  RequireSize("radius", radius);
  RequireCount(count, 3);
  const auto vertex = [&](int k) -> Eigen::Vector2d {
    const double angle = (2.0 * (k % count) - 1.0) * std::numbers::pi / count;
    return {radius * std::cos(angle), radius * std::sin(angle)};
  };
  BoundaryMesh mesh;
  mesh.length_unit = radius;
  mesh.loop_begin = {0, count};
  for (int k = 0; k < count; ++k) mesh.elements.push_back({vertex(k), vertex(k + 1)});
  return mesh;
}

BoundaryMesh MeshPolygon(const Outline& outline, int count) {
  CheckOutline(outline);
  RequireCount(count, 3);
  std::vector<Loop> loops{Turned(outline.outer, true)};
  for (const auto& hole : outline.holes) loops.push_back(Turned(hole, false));
  return MeshLoops(loops, count);
}

}  // namespace palpate
