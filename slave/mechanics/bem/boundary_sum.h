// Displacements and tractions on the whole boundary as a sum over what nodes were given.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/bem/greens_functions.h"

namespace palpate {

class BoundarySum {
 public:
  explicit BoundarySum(const GreensFunctions& greens);
  // The traction of node `j` that the reference problem leaves free, or the amplitude of one of the
  // blocks beyond the nodes. O(N).
  void Add(int j, const Eigen::Vector2d& value);
  void Finish(std::vector<Eigen::Vector2d>* displacement, std::vector<Eigen::Vector2d>* traction);

 private:
  const GreensFunctions& greens_;
  std::vector<Eigen::Vector2d> answer_, given_;
};

}  // namespace palpate
