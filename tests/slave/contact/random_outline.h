// Random bodies for tests: the same seed gives the same body.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <random>
#include <vector>

#include "slave/mesh/outline.h"

namespace palpate {

inline std::vector<Eigen::Vector2d> Star(int corners, double least, double most,
                                         std::mt19937* random) {
  std::uniform_real_distribution<double> radius(least, most), jitter(-0.4, 0.4);
  std::vector<Eigen::Vector2d> loop;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * (i + jitter(*random)) / corners;
    loop.push_back(radius(*random) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return loop;
}

// A star-shaped outline around the origin, radii 0.5 to 1, with 5 to 40 corners; every other one
// has a hole of radius 0.05 to 0.1. Concave corners and slivers abound.
inline Outline RandomOutline(std::mt19937* random) {
  // Five corners or more keep the origin inside, well away from the edges of the hole.
  const int corners = 5 + static_cast<int>((*random)() % 36);
  Outline outline{Star(corners, 0.5, 1, random), {}};
  if ((*random)() % 2 == 0) outline.holes.push_back(Star(7, 0.05, 0.1, random));
  return outline;
}

// The same mesh with the elements of every loop numbered from another one on.
inline BoundaryMesh Renumbered(const BoundaryMesh& mesh, int shift) {
  BoundaryMesh other = mesh;
  for (std::size_t k = 0; k + 1 < mesh.loop_begin.size(); ++k) {
    const auto begin = other.elements.begin() + mesh.loop_begin[k];
    const auto end = other.elements.begin() + mesh.loop_begin[k + 1];
    std::rotate(begin, begin + shift % (end - begin), end);
  }
  return other;
}

}  // namespace palpate
