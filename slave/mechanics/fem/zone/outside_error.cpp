#include "slave/mechanics/fem/zone/outside_error.h"

#include <algorithm>
#include <cmath>

#include "slave/mechanics/fem/zone/near/matrix_times.h"
#include "slave/mesh/index.h"

namespace palpate {
namespace {

// Nodes so near to the border of the zone have the displacement by every one of its nodes [radii].
constexpr double kRim = 0.35;

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
  u_ = residual_ = before_ = VectorXd::Zero(3 * static_cast<int>(nodes.size()));
  nodes_f_ = VectorXf::Zero(u_.size());
  const FieldSamples& samples = own_.samples();
  work_ = held_ = load_ = VectorXd::Zero(samples.unknowns());
  load_f_ = VectorXf::Zero(samples.unknowns());
  const auto require = [](bool known) {
    if (!known) throw std::runtime_error("the displacements outside a zone are not known");
  };
  require(green.Gather(nodes, samples.nodes, &green_));
  dual_.setZero(u_.size(), 3);
  FindDual();
  const std::span<const int> all = nodes;
  require(green.Gather(all.first(rim), own_.zone().nodes, &rim_));
  rim_f_ = VectorXf::Zero(rim_.rows());
  zone_f_ = VectorXf::Zero(rim_.cols());
  Eigen::MatrixXf between;
  require(green.Gather(samples.nodes, samples.nodes, &between));
  MatrixXd compliance = between.cast<double>();
  for (int i = 0; i < compliance.rows(); ++i) {  // held components
    if (compliance(i, i) == 0) compliance(i, i) = 1;
  }
  between_.compute(compliance);
  require(between_.info() == Eigen::Success);
  for (std::size_t j = 0; j < parts.size(); ++j) {
    if (j == own || nodes.empty()) continue;
    others_.push_back({parts[j], Transfer(green, nodes, parts[j]->samples().nodes),
                       VectorXd::Zero(parts[j]->samples().unknowns())});
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

// By the own load as sampled, the same next to the zone, and by the load of each other zone.
void OutsideError::AddDisplacement(std::size_t piece) noexcept {
  if (piece == 0) {
    own_.samples().SampleForces(own_.load(), &load_);
    load_f_ = load_.cast<float>();
    MatrixTimes(green_, load_f_, &nodes_f_);
  } else if (piece == 1) {
    zone_f_ = own_.load().cast<float>();
    MatrixTimes(rim_, zone_f_, &rim_f_);
    nodes_f_.head(rim_f_.size()) = rim_f_;
    u_ = nodes_f_.cast<double>();
  } else {
    Source& source = others_[piece - 2];
    source.part->samples().SampleForces(source.part->load(), &source.load);
    source.transfer.Add(source.load, &u_);
  }
}

// The residual moves the samples by -work.
void OutsideError::Correct() noexcept {
  own_.HeldLoad(work_, &held_);
  between_.solveInPlace(work_);
  load_f_ = -(held_ + work_).cast<float>();
  MatrixTimes(green_, load_f_, &nodes_f_);
  u_ += nodes_f_.cast<double>();
}

// What the residual's change at every node does to the force, without regard to signs: the samples
// know the correction only roughly.
void OutsideError::FindChange() noexcept {
  before_.swap(residual_);
  residual_.setZero();
  tets_->AddNonlinearForce(u_.data(), residual_.data());
  Vector3d change = Vector3d::Zero();
  for (int n = 0; 3 * n < residual_.size(); ++n) {
    const Vector3d here = residual_.segment<3>(3 * n) - before_.segment<3>(3 * n);
    for (int c = 0; c < 3; ++c) change[c] += std::abs(dual_.col(c).segment<3>(3 * n).dot(here));
  }
  second_ = scale_ * change.norm();
}

// By the contact's own motion along each axis.
void OutsideError::FindDual() noexcept {
  for (int c = 0; c < 3; ++c) {
    load_f_ = own_.dual().sampled_load.col(c).cast<float>();
    MatrixTimes(green_, load_f_, &nodes_f_);
    dual_.col(c) = nodes_f_.cast<double>();
  }
}

bool OutsideError::Advance() noexcept {
  if (size() == 0) return true;
  const std::size_t sources = 2 + others_.size();
  if (piece_ < sources) {
    AddDisplacement(piece_);
  } else if (piece_ == sources) {
    FindResidual(&first_);
  } else if (piece_ == sources + 1) {
    Correct();
  } else if (piece_ == sources + 2 && own_.contact().tool) {
    FindDual();
  } else {
    FindChange();
    error_ = first_;
    piece_ = 0;
    return true;
  }
  ++piece_;
  return false;
}

}  // namespace palpate
