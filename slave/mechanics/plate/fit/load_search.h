// Where a plate is pressed, roughly: the best of 91 places spread over it, by the small-deflection
// shape. Nondimensional as in green.h.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/green.h"

namespace palpate::plate {

class LoadSearch {
 public:
  // Loads over discs of `load_radius`, their centres up to `farthest` from the plate's.
  LoadSearch(double load_radius, double farthest);

  // The shapes at these points; nothing to do where they are those of the last call. Allocates.
  void SetPoints(std::span<const Eigen::Vector2d> points);

  struct Found {
    Eigen::Vector2d place{0, 0};
    double deflection = 0;  // at the place, in the unit of the values
    double explained = 0;   // of the sum of squared weighted values
  };
  // `values` of the deflections at the points times their `weights`. What the orthonormal columns
  // of `left_out` explain does not count, if there are any. Only places up to `farthest`. No
  // allocation.
  [[nodiscard]] Found Best(const Eigen::VectorXd& values, const Eigen::VectorXd& weights,
                           const Eigen::Matrix<double, Eigen::Dynamic, 3>* left_out,
                           double farthest) noexcept;

 private:
  std::vector<Disc> places_;
  std::vector<double> under_load_;  // deflection at the place itself under a load of one
  std::vector<Eigen::Vector2d> points_;
  Eigen::MatrixXd shapes_;  // column per place
  Eigen::VectorXd shape_;
};

}  // namespace palpate::plate
