#include "slave/mechanics/fem/zone/zone_coupling.h"

#include <cmath>
#include <vector>

#include <Eigen/LU>

#include "slave/mechanics/fem/zone/near/matrix_times.h"
#include "slave/mesh/index.h"

namespace palpate {

using Eigen::MatrixXd;
using Eigen::MatrixXf;
using Eigen::VectorXf;

namespace {

std::vector<int> NodesOf(const ZonePart& part) {
  std::vector<int> nodes;
  for (const auto& point : part.contact().points) {
    for (const auto& [node, weight] : point) nodes.push_back(part.zone().nodes[Index(node)]);
  }
  return nodes;
}

// From three columns per node those of three per point.
MatrixXf AtPoints(const ZoneContact& contact, const MatrixXf& at_nodes) {
  MatrixXf columns = MatrixXf::Zero(at_nodes.rows(), contact.unknowns());
  int node = 0, point = 0;
  for (const auto& weights : contact.points) {
    for (const auto& [number, weight] : weights) {
      columns.middleCols<3>(point) += static_cast<float>(weight) * at_nodes.middleCols<3>(node);
      node += 3;
    }
    point += 3;
  }
  return columns;
}

}  // namespace

ZoneCoupling::ZoneCoupling(NearGreen& green, const ZonePart& to, const ZonePart& from, bool near)
    : from_(&from), near_(near), samples_(green, to.samples().nodes, from.samples().nodes) {
  const std::vector<int> pressed = NodesOf(from), touched = NodesOf(to);
  const std::vector<int>& nodes = near ? to.zone().nodes : to.samples().nodes;
  columns_ = AtPoints(from.contact(), Transfer(green, nodes, pressed).matrix());
  const MatrixXf between = AtPoints(from.contact(), Transfer(green, touched, pressed).matrix());
  at_points_ = AtPoints(to.contact(), between.transpose()).transpose();
}

void ZoneCoupling::Add(const MatrixXf& columns, VectorXf* u) const noexcept {
  AddPlaces(columns, from_->pressed().points, from_->pressed().forces, u);
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
