#include "slave/pipeline/organ/moving_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <Eigen/Geometry>

#include "shared/geometry/index.h"
#include "slave/contact/box_tree.h"
#include "slave/contact/surface_contact.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr int kLeafSize = 4;

}  // namespace

MovingSurface::MovingSurface(const Nodes& nodes, std::vector<std::array<int, 3>> triangles)
    : triangles_(std::move(triangles)),
      ends_(triangles_.size()),
      border_(static_cast<std::size_t>(nodes.cols()), false),
      order_(triangles_.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  Build(nodes, 0, static_cast<int>(order_.size()));
  FindBorder();
  Move(nodes);
}

int MovingSurface::Build(const Nodes& nodes, int begin, int end) {
  const int number = static_cast<int>(boxes_.size());
  boxes_.emplace_back();
  boxes_[Index(number)].begin = begin;
  boxes_[Index(number)].end = end;
  if (end - begin <= kLeafSize) return number;
  const auto middle = [&](int triangle) -> Vector3d {
    const auto& t = triangles_[Index(triangle)];
    return nodes.col(t[0]) + nodes.col(t[1]) + nodes.col(t[2]);
  };
  Vector3d lower = middle(order_[Index(begin)]), upper = lower;
  for (int k = begin; k < end; ++k) {
    lower = lower.cwiseMin(middle(order_[Index(k)]));
    upper = upper.cwiseMax(middle(order_[Index(k)]));
  }
  Eigen::Index axis = 0;
  (upper - lower).maxCoeff(&axis);
  const int half = (begin + end) / 2;
  std::nth_element(order_.begin() + begin, order_.begin() + half, order_.begin() + end,
                   [&](int a, int b) { return middle(a)[axis] < middle(b)[axis]; });
  const int left = Build(nodes, begin, half), right = Build(nodes, half, end);
  boxes_[Index(number)].left = left;
  boxes_[Index(number)].right = right;
  return number;
}

void MovingSurface::FindBorder() {
  std::map<std::pair<int, int>, int> count;
  const auto edge = [](const auto& t, std::size_t i) {
    return std::pair(std::min(t[i], t[(i + 1) % 3]), std::max(t[i], t[(i + 1) % 3]));
  };
  for (const auto& t : triangles_) {
    for (std::size_t i = 0; i < 3; ++i) ++count[edge(t, i)];
  }
  for (std::size_t k = 0; k < triangles_.size(); ++k) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [a, b] = edge(triangles_[k], i);
      ends_[k][i] = count[{a, b}] == 1;
      if (ends_[k][i]) border_[Index(a)] = border_[Index(b)] = true;
    }
  }
}

void MovingSurface::Move(const Nodes& nodes) noexcept {
  nodes_ = &nodes;
  for (auto box = boxes_.rbegin(); box != boxes_.rend(); ++box) {
    if (box->left >= 0) {
      const Box &a = boxes_[Index(box->left)], &b = boxes_[Index(box->right)];
      box->lower = a.lower.cwiseMin(b.lower);
      box->upper = a.upper.cwiseMax(b.upper);
      continue;
    }
    box->lower.setConstant(std::numeric_limits<double>::infinity());
    box->upper = -box->lower;
    for (int k = box->begin; k < box->end; ++k) {
      for (const int node : triangles_[Index(order_[Index(k)])]) {
        box->lower = box->lower.cwiseMin(nodes.col(node));
        box->upper = box->upper.cwiseMax(nodes.col(node));
      }
    }
  }
}

MovingSurface::Place MovingSurface::Nearest(const Vector3d& p_O) const noexcept {
  Place place;
  if (!p_O.allFinite()) return place;
  double limit = std::numeric_limits<double>::max();
  const auto distance = [&](const Box& box) {
    return (box.lower - p_O).cwiseMax(p_O - box.upper).cwiseMax(0).squaredNorm();
  };
  TrianglePlace best;
  VisitNearest(boxes_, limit, distance, [&](int k) {
    const int triangle = order_[Index(k)];
    const auto& t = triangles_[Index(triangle)];
    const TrianglePlace met =
        ClosestOnTriangle(p_O, {nodes_->col(t[0]), nodes_->col(t[1]), nodes_->col(t[2])},
                          {t[0] < t[1], t[1] < t[2], t[2] < t[0]});
    if (!(met.distance_squared < limit)) return;
    limit = met.distance_squared;
    best = met;
    place.triangle = triangle;
  });
  if (place.triangle < 0) return place;
  const auto& t = triangles_[Index(place.triangle)];
  place.weights = best.weights;
  place.distance = std::sqrt(best.distance_squared);
  place.n_O =
      AreaNormal({nodes_->col(t[0]), nodes_->col(t[1]), nodes_->col(t[2])}).stableNormalized();
  place.height = place.n_O.dot(p_O - nodes_->col(t[0]));
  place.at_border =
      (best.feature == TrianglePlace::Feature::kEdge &&
       ends_[Index(place.triangle)][Index(best.corner)]) ||
      (best.feature == TrianglePlace::Feature::kCorner && border_[Index(t[Index(best.corner)])]);
  return place;
}

}  // namespace palpate
