// DotLayout holds the positions of the dots of an array on the object at rest, frame O.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/scene/scene.h"

namespace palpate {

// `count` points of the lattice `spacing` [m] that lie nearest to the origin, row by row (y, then
// x, rising). The lattice is centred on a point, on the midpoint of an edge or on the centre of a
// cell, such that the points form a symmetric figure; 31 points 15 by 10 mm are seven rows of 3, 5,
// 5, 5, 5, 5, 3 within 36.1 mm. Throws std::invalid_argument: count < 1, spacing not > 0.
std::vector<Eigen::Vector2d> LatticePlaces(int count, const Eigen::Vector2d& spacing);

// The array of a scene: its file `layout` (CSV with columns x, y [m]) or its lattice. Throws
// std::runtime_error (the file), std::invalid_argument (the numbers).
std::vector<Eigen::Vector2d> DotPlaces(const PointTracking& points);

}  // namespace palpate
