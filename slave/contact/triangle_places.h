// The closest point of a triangle, to which of its features it belongs, and area weights.
#pragma once

#include <array>
#include <cstdint>

#include <Eigen/Core>

namespace palpate {

struct TrianglePlace {
  // kEdge: between corners `corner` and `corner + 1` (mod 3). kCorner: corner `corner`.
  enum class Feature : std::uint8_t { kFace, kEdge, kCorner } feature = Feature::kFace;
  int corner = 0;
  Eigen::Vector3d p{0, 0, 0};        // [m]
  Eigen::Vector3d weights{0, 0, 0};  // of the corners, each 0 to 1, sum 1
  double distance_squared = 0;       // [m^2]
};

// The triangle's point closest to `p`; triangles without area are the segments or points they are.
// Two triangles that share an edge answer the same to the last bit where it is the closest, if the
// edge runs from the corner that comes first in both: `first_smaller` says of edge i whether corner
// i comes before corner i + 1.
TrianglePlace ClosestOnTriangle(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& abc,
                                const std::array<bool, 3>& first_smaller) noexcept;

// Twice the area times the normal; zero where the triangle is thinner than rounding.
Eigen::Vector3d AreaNormal(const std::array<Eigen::Vector3d, 3>& abc) noexcept;

}  // namespace palpate
