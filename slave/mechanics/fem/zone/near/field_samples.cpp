#include "slave/mechanics/fem/zone/near/field_samples.h"

#include <algorithm>
#include <numeric>

#include <Eigen/QR>
#include <cblas.h>

#include "slave/mesh/index.h"

namespace palpate {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
constexpr int kNearAnchors = 32;         // of one zone
constexpr double kAnchorsAround = 1.25;  // of the extent of the nodes

void FieldSamples::AddField(const VectorXd& sampled, VectorXd* values) noexcept {
  few_ = sampled.cast<float>();
  many_.resize(values->size());
  const auto n = static_cast<int>(weights.rows()), k = static_cast<int>(weights.cols());
  if (weights.size() == 0) return;
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, 3, n, k, 1, few_.data(), 3, weights.data(),
              n, 0, many_.data(), 3);
  *values += many_.cast<double>();
}

void FieldSamples::SampleForces(const VectorXd& forces, VectorXd* sampled) noexcept {
  many_ = forces.cast<float>();
  few_.resize(sampled->size());
  const auto n = static_cast<int>(weights.rows()), k = static_cast<int>(weights.cols());
  if (weights.size() == 0) return;
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, 3, k, n, 1, many_.data(), 3,
              weights.data(), n, 0, few_.data(), 3);
  *sampled = few_.cast<double>();
}

FieldSamples SamplesAtAnchors(const NearGreen& green, std::span<const int> nodes) {
  std::vector<Vector3d> targets, sources;
  Vector3d centre = Vector3d::Zero();
  for (const int node : nodes) {
    targets.push_back(green.positions()[Index(node)]);
    centre += targets.back() / static_cast<double>(nodes.size());
  }
  double extent = 0;
  for (const Vector3d& target : targets) extent = std::max(extent, (target - centre).norm());
  for (const int anchor : green.anchors()) sources.push_back(green.positions()[Index(anchor)]);
  std::vector<int> order(sources.size()), around;
  std::iota(order.begin(), order.end(), 0);
  const auto distance = [&](int anchor) { return (sources[Index(anchor)] - centre).norm(); };
  std::ranges::sort(order, {}, distance);
  for (const int anchor : order) {
    const bool few = static_cast<int>(around.size()) < kNearAnchors;
    if (few || distance(anchor) <= kAnchorsAround * extent) around.push_back(anchor);
  }
  FieldSamples samples;
  SpreadNodes(sources, around, kNearAnchors, &samples.nodes);
  std::vector<Vector3d> chosen;
  for (const int anchor : samples.nodes) chosen.push_back(sources[Index(anchor)]);
  samples.weights = SampleWeights(chosen, targets);
  return samples;
}

Eigen::MatrixXf SampleWeights(std::span<const Vector3d> samples,
                              std::span<const Vector3d> targets) {
  const auto k = static_cast<int>(samples.size()), n = static_cast<int>(targets.size());
  Vector3d low = samples.front(), high = low, mean = Vector3d::Zero();
  for (const Vector3d& p : samples) low = low.cwiseMin(p), high = high.cwiseMax(p), mean += p / k;
  const double size = std::max(1e-300, (high - low).maxCoeff());
  const auto basis = [&](const Vector3d& p) {
    VectorXd row(k + 4);
    for (int j = 0; j < k; ++j) row[j] = (p - samples[Index(j)]).norm() / size;
    row[k] = 1;
    row.tail<3>() = (p - mean) / size;
    return row;
  };
  MatrixXd system = MatrixXd::Zero(k + 4, k + 4), at(k + 4, n);
  for (int i = 0; i < k; ++i) {
    const VectorXd row = basis(samples[Index(i)]);
    system.row(i) = row;
    system.block<4, 1>(k, i) = row.tail<4>();
  }
  for (int i = 0; i < n; ++i) at.col(i) = basis(targets[Index(i)]);
  // The system is symmetric; samples in a plane have no slope across it: least squares.
  const MatrixXd solved = system.completeOrthogonalDecomposition().solve(at);
  return solved.topRows(k).transpose().cast<float>();
}

}  // namespace palpate
