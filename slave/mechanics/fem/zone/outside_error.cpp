#include "slave/mechanics/fem/zone/outside_error.h"

#include <algorithm>
#include <cmath>

#include "shared/geometry/index.h"
#include "slave/mechanics/fem/zone/matrix_times.h"

namespace palpate {
namespace {

// Nodes so near to the border of the zone have the displacement by every one of its nodes [radii].
constexpr double kRim = 0.35;
// What further corrections add by what the first one adds [-]. [tuned: ZoneExtremes.PoissonRatio]
constexpr double kFurther = 5;

}  // namespace

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Eigen::VectorXf;

OutsideError::OutsideError(NearGreen& green, const SolidMesh& mesh, double nu,
                           const std::vector<char>& taken, std::span<ZonePart* const> parts,
                           std::size_t own, const Region& region)
    : own_(*parts[own]) {
  std::vector<int> number(mesh.nodes.size(), -1), nodes;
  std::vector<Vector3d> positions;
  std::vector<std::array<int, 4>> corners;
  const auto number_of = [&](int node) {
    int& known = number[Index(node)];
    if (known < 0) {
      known = static_cast<int>(nodes.size());
      nodes.push_back(node);
      positions.push_back(green.positions()[Index(node)]);
    }
    return known;
  };
  double within = 0, beyond = 0;
  std::vector<double> moduli;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const double distance = (green.positions()[n] - region.centre).norm();
    if (std::abs(distance - region.radius) < kRim * region.radius) number_of(static_cast<int>(n));
  }
  const std::size_t rim = nodes.size();
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (taken[t] != 0) continue;
    Vector3d centroid = Vector3d::Zero();
    for (const int node : mesh.tets[t]) centroid += green.positions()[Index(node)] / 4;
    const double distance = (centroid - region.centre).norm();
    const double weight = SignedVolume(mesh, static_cast<int>(t)) * std::pow(distance, -6);
    (distance > region.reach ? beyond : within) += weight;
    if (distance > region.reach) continue;
    moduli.push_back(mesh.ModulusOf(t));
    auto& tet = corners.emplace_back(mesh.tets[t]);
    for (int& node : tet) node = number_of(node);
  }
  if (within > 0) scale_ = 1 + beyond / within;
  tets_.emplace(corners, positions, nu, moduli);
  u_ = residual_ = VectorXd::Zero(3 * static_cast<int>(nodes.size()));
  nodes_f_ = VectorXf::Zero(u_.size());
  const FieldSamples& samples = own_.samples();
  work_ = held_ = VectorXd::Zero(samples.unknowns());
  load_f_ = VectorXf::Zero(samples.unknowns());
  green.Gather(nodes, samples.nodes, &green_);
  const std::span<const int> all = nodes;
  green.Gather(all.first(rim), own_.zone().nodes, &rim_);
  rim_f_ = VectorXf::Zero(rim_.rows());
  zone_f_ = VectorXf::Zero(rim_.cols());
  Eigen::MatrixXf between;
  green.Gather(samples.nodes, samples.nodes, &between);
  MatrixXd compliance = between.cast<double>();
  for (int i = 0; i < compliance.rows(); ++i) {  // held components
    if (compliance(i, i) == 0) compliance(i, i) = 1;
  }
  between_.compute(compliance);
  for (std::size_t j = 0; j < parts.size(); ++j) {
    if (j == own || nodes.empty()) continue;
    others_.push_back({parts[j], Transfer(green, nodes, parts[j]->samples().nodes)});
  }
}

void OutsideError::FindResidual(Vector3d* error) noexcept {
  residual_.setZero();
  tets_->AddNonlinearForce(u_.data(), residual_.data());
  nodes_f_ = residual_.cast<float>();
  TransposedTimes(green_, nodes_f_, &load_f_);
  work_ = load_f_.cast<double>();
  error->noalias() = scale_ * (own_.dual().sampled_load.transpose() * work_);
}

std::size_t OutsideError::bytes() const {
  std::size_t bytes = 0;
  for (const Source& source : others_) bytes += source.transfer.bytes();
  return bytes;
}

double OutsideError::bound() const {
  const double growth = std::max(0.0, second_.norm() - error_.norm());
  return error_.norm() + (second_ - error_).norm() + kFurther * growth;
}

void OutsideError::Estimate() noexcept {
  if (size() == 0) return;
  load_f_ = own_.sampled_load().cast<float>();
  MatrixTimes(green_, load_f_, &nodes_f_);
  zone_f_ = own_.load().cast<float>();
  MatrixTimes(rim_, zone_f_, &rim_f_);
  nodes_f_.head(rim_f_.size()) = rim_f_;
  u_ = nodes_f_.cast<double>();
  for (Source& source : others_) source.transfer.Add(source.part->sampled_load(), &u_);
  FindResidual(&error_);
  own_.HeldLoad(work_, &held_);  // the residual moves the samples by -work
  between_.solveInPlace(work_);
  load_f_ = -(held_ + work_).cast<float>();
  MatrixTimes(green_, load_f_, &nodes_f_);
  u_ += nodes_f_.cast<double>();
  FindResidual(&second_);
}

}  // namespace palpate
