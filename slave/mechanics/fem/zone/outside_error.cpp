#include "slave/mechanics/fem/zone/outside_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "shared/geometry/index.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Share of the duals' cubed strains that may be left out [-]; the estimate grows by as much.
constexpr double kLeftOut = 0.02;

// Of one tetrahedron: the cubes of the gradients of three displacement fields times the volume. The
// residual grows with their square, the work on the dual with their cube.
double CubedGradients(const std::vector<Vector3d>& nodes, const std::array<int, 4>& tet,
                      const MatrixXd& fields) {
  Matrix3d edges;
  for (int a = 0; a < 3; ++a) edges.col(a) = nodes[Index(tet[Index(a + 1)])] - nodes[Index(tet[0])];
  const Matrix3d inverse = edges.inverse();
  double sum = 0;
  for (int k = 0; k < fields.cols(); ++k) {
    Matrix3d moved;
    for (int a = 0; a < 3; ++a) {
      moved.col(a) =
          fields.block<3, 1>(3 * tet[Index(a + 1)], k) - fields.block<3, 1>(3 * tet[0], k);
    }
    sum += std::pow((moved * inverse).norm(), 3);
  }
  return sum * edges.determinant() / 6;
}

}  // namespace

OutsideError::OutsideError(const ZonePlaces& places, std::span<const Source> sources) {
  const SolidMesh& mesh = places.mesh();
  std::vector<int> zones(mesh.tets.size(), 0);
  for (const Source& source : sources) {
    for (const int t : source.place->body.zone.tets) ++zones[Index(t)];
  }
  std::vector<double> share(mesh.tets.size(), 0);
  for (const Source& source : sources) {
    const MatrixXd dual = (source.place->far * source.dual->cast<float>()).cast<double>();
    std::vector<double> own(mesh.tets.size(), 0);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      if (zones[t] != 1) own[t] = CubedGradients(places.positions(), mesh.tets[t], dual);
    }
    const double whole = std::accumulate(own.begin(), own.end(), 0.0);
    for (std::size_t t = 0; whole > 0 && t < own.size(); ++t) share[t] += own[t] / whole;
  }
  std::vector<int> order(mesh.tets.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, [&](int a, int b) { return share[Index(a)] > share[Index(b)]; });
  double left = static_cast<double>(sources.size());
  std::vector<int> number(mesh.nodes.size(), -1), nodes;
  std::vector<Vector3d> positions;
  std::vector<std::array<int, 4>> outside, shared;
  for (const int t : order) {
    if (left <= kLeftOut || !(share[Index(t)] > 0)) break;
    left -= share[Index(t)];
    auto& tet = (zones[Index(t)] == 0 ? outside : shared).emplace_back(mesh.tets[Index(t)]);
    for (int& node : tet) {
      if (number[Index(node)] < 0) {
        number[Index(node)] = static_cast<int>(nodes.size());
        nodes.push_back(node);
        positions.push_back(places.positions()[Index(node)]);
      }
      node = number[Index(node)];
    }
  }
  outside_.emplace(outside, positions, places.nu());
  shared_.emplace(shared, positions, places.nu());
  for (const Source& source : sources) {
    MatrixXd& far = far_.emplace_back(3 * static_cast<int>(nodes.size()), source.place->far.cols());
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      far.middleRows<3>(3 * static_cast<int>(n)) =
          source.place->far.middleRows<3>(3 * nodes[n]).cast<double>();
    }
  }
  u_ = residual_ = linear_ = VectorXd::Zero(3 * static_cast<int>(nodes.size()));
}

void OutsideError::Compose(int source, const VectorXd& amplitudes) noexcept {
  u_.noalias() += far_[Index(source)] * amplitudes;
}

void OutsideError::FindResidual() noexcept {
  residual_.setZero();
  linear_.setZero();
  outside_->AddForce(u_.data(), residual_.data());
  shared_->AddLinearForce(u_.data(), residual_.data());
  outside_->AddLinearForce(u_.data(), linear_.data());
  shared_->AddForce(u_.data(), linear_.data());
  residual_ -= linear_;
}

void OutsideError::Work(int source, VectorXd* work) noexcept {
  work->noalias() = 1 / (1 - kLeftOut) * (far_[Index(source)].transpose() * residual_);
}

}  // namespace palpate
