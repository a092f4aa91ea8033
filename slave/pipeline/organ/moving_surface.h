// The nearest place of a surface whose nodes move: a tree of boxes that is built once and fitted
// again to every shape.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Not thread-safe. Open surfaces may have a border.
class MovingSurface {
 public:
  using Nodes = Eigen::Matrix3Xd;  // column per node, frame O [m]

  struct Place {
    int triangle = -1;
    Eigen::Vector3d weights{0, 0, 0};  // of the triangle's nodes, sum 1
    Eigen::Vector3d n_O{0, 0, 0};      // unit normal of the triangle
    double height = 0;                 // of the point over the triangle's plane [m]
    double distance = 0;               // from the place [m]
    bool at_border = false;            // the surface ends there: the point may lie beyond
  };

  // `nodes` as they are when the tree is built. At least one triangle. O(N log N).
  MovingSurface(const Nodes& nodes, std::vector<std::array<int, 3>> triangles);

  // Fits the boxes to the nodes' places now, which must stay until the next call. Allocation-free.
  void Move(const Nodes& nodes) noexcept;
  // Triangle -1: p is not finite. O(log N), allocation-free.
  [[nodiscard]] Place Nearest(const Eigen::Vector3d& p_O) const noexcept;
  [[nodiscard]] const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

 private:
  struct Box {
    Eigen::Vector3d lower, upper;
    int begin = 0, end = 0;  // of order_
    int left = -1, right = -1;
  };
  int Build(const Nodes& nodes, int begin, int end);
  void FindBorder();

  std::vector<std::array<int, 3>> triangles_;
  std::vector<std::array<bool, 3>> ends_;  // per triangle: the edge from corner i is the border
  std::vector<bool> border_;               // per node
  std::vector<int> order_;
  std::vector<Box> boxes_;  // parents before their children
  const Nodes* nodes_ = nullptr;
};

}  // namespace palpate
