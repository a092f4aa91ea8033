// A body's edges for meshing: divided at the ends of the tool's contact, each piece marked as
// fixed, moved or free.
#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/site/camera/delaunay.h"
#include "slave/site/camera/true_body.h"

namespace palpate::site {

enum Tag : int { kHeldX = 1, kHeldY = 2, kPatch = 4 };

struct TaggedOutline {
  std::vector<Eigen::Vector2d> points;
  std::vector<Segment> segments;
};

// The body's edges in parts of `unit` [m], divided at the ends of the patch: from and to along
// `loop` [m].
TaggedOutline Divide(const TrueBody& body, int loop, std::pair<double, double> patch, double unit);

}  // namespace palpate::site
