// What forces on some nodes do to others: Green's functions where they reach, and beyond, where the
// displacement is smooth, interpolated between anchors.
#pragma once

#include <span>

#include <Eigen/Core>

#include "slave/mechanics/fem/zone/near/near_green.h"

namespace palpate {

class Transfer {
 public:
  Transfer(NearGreen& green, std::span<const int> to, std::span<const int> from);

  // u += the displacement by these forces, three numbers per node. Does not allocate.
  void Add(const Eigen::VectorXd& forces, Eigen::VectorXd* u) noexcept;
  [[nodiscard]] const Eigen::MatrixXf& matrix() const { return matrix_; }

 private:
  Eigen::MatrixXf matrix_;
  Eigen::VectorXf forces_f_, u_f_;
};

}  // namespace palpate
