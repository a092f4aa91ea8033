// Finds the neighbours of points.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace palpate::study {

// Const members are thread-safe. Distances are exact to single precision.
class PointTree {
 public:
  // O(N log N). Throws std::invalid_argument: no points, or one that is not finite.
  explicit PointTree(std::span<const Eigen::Vector3d> points);
  ~PointTree();

  struct Neighbour {
    std::size_t index = 0;
    double distance = 0;  // [m]
  };
  // `p` must be finite.
  [[nodiscard]] Neighbour Nearest(const Eigen::Vector3d& p) const;
  // Distance from one of the tree's own points to the next of them that is elsewhere [m]; 0: many
  // are there.
  [[nodiscard]] double NextTo(const Eigen::Vector3d& p) const;
  // Those within `radius` [m], in no particular order.
  void Within(const Eigen::Vector3d& p, double radius, std::vector<std::size_t>* indices) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace palpate::study
