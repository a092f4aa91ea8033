#include "slave/mechanics/fem/zone/near/transfer.h"

#include <vector>

#include "slave/mechanics/fem/zone/near/field_samples.h"
#include "slave/mechanics/fem/zone/near/matrix_times.h"
#include "slave/mesh/index.h"

namespace palpate {

Transfer::Transfer(NearGreen& green, std::span<const int> to, std::span<const int> from) {
  std::vector<std::array<int, 2>> missed;
  green.Gather(to, from, &matrix_, &missed);
  forces_f_.setZero(matrix_.cols());
  u_f_.setZero(matrix_.rows());
  if (missed.empty()) return;
  const FieldSamples anchors = SamplesAtAnchors(green, to);
  Eigen::MatrixXf at_anchors;
  green.GatherAtAnchors(anchors.nodes, from, &at_anchors);
  for (const auto& [i, j] : missed) {
    Eigen::Matrix3f block = Eigen::Matrix3f::Zero();
    for (int a = 0; a < anchors.weights.cols(); ++a) {
      block += anchors.weights(i, a) * at_anchors.block<3, 3>(3 * a, 3 * j);
    }
    matrix_.block<3, 3>(3 * i, 3 * j) = block;
  }
}

void Transfer::Add(const Eigen::VectorXd& forces, Eigen::VectorXd* u) noexcept {
  forces_f_ = forces.cast<float>();
  MatrixTimes(matrix_, forces_f_, &u_f_);
  *u += u_f_.cast<double>();
}

}  // namespace palpate
