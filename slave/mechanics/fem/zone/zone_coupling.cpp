#include "slave/mechanics/fem/zone/zone_coupling.h"

#include <cmath>
#include <vector>

#include <Eigen/LU>

#include "shared/geometry/index.h"
#include "slave/mechanics/fem/zone/matrix_times.h"

namespace palpate {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using Eigen::VectorXf;

ZoneCoupling::ZoneCoupling(NearGreen& green, const ZonePart& to, const ZonePart& from)
    : from_(&from), samples_(green, to.samples().nodes, from.samples().nodes) {
  std::vector<int> touched;
  for (const auto& point : from.contact().points) {
    for (const auto& [node, weight] : point) touched.push_back(from.zone().nodes[Index(node)]);
  }
  const Transfer all(green, to.zone().nodes, touched);
  columns_.setZero(all.matrix().rows(), from.contact().unknowns());
  int column = 0, point = 0;
  for (const auto& weights : from.contact().points) {
    for (const auto& [node, weight] : weights) {
      columns_.middleCols<3>(point) +=
          static_cast<float>(weight) * all.matrix().middleCols<3>(column);
      column += 3;
    }
    point += 3;
  }
  at_points_.setZero(to.contact().unknowns(), columns_.cols());
  for (std::size_t p = 0; p < to.contact().points.size(); ++p) {
    for (const auto& [node, weight] : to.contact().points[p]) {
      at_points_.middleRows<3>(3 * static_cast<int>(p)) +=
          static_cast<float>(weight) * columns_.middleRows<3>(3 * node);
    }
  }
}

void ZoneCoupling::AddAtPoints(VectorXf* at) const noexcept {
  AddPlaces(at_points_, from_->pressed_points(), from_->pressed_forces(), at);
}

void ZoneCoupling::AddAtNodes(VectorXf* u) const noexcept {
  AddPlaces(columns_, from_->pressed_points(), from_->pressed_forces(), u);
}

void ZoneCoupling::AddAtSamples(const VectorXd& forces, VectorXd* samples) noexcept {
  samples_.Add(forces, samples);
}

double ZoneCoupling::Gain(const ZonePart& to) const {
  const MatrixXd& forces = from_->dual().forces;
  Eigen::Matrix3d total = Eigen::Matrix3d::Zero();
  for (int k = 0; k < forces.rows(); ++k) total.row(k % 3) += forces.row(k);
  if (!(std::abs(total.determinant()) > 0)) return 0;  // it touches nothing
  const Eigen::Matrix3d caused =
      to.dual().forces.transpose() * (at_points_.cast<double>() * forces);
  return (caused * total.inverse()).norm();
}

}  // namespace palpate
