#include "slave/pipeline/organ/cloud_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/geometry/index.h"
#include "shared/statistics/robust.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Columns = Eigen::Matrix<float, PatchGreens::kColumns, 1>;

constexpr int kCells = 24;    // of the seen surface: larger than what errs alike
constexpr double kBends = 3;  // scatters from which a point counts less

MovingSurface::Nodes AsMatrix(const std::vector<Vector3d>& nodes) {
  MovingSurface::Nodes matrix(3, static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < nodes.size(); ++i)
    matrix.col(static_cast<Eigen::Index>(i)) = nodes[i];
  return matrix;
}

// Of triangles, by the nearest of places far from each other.
std::vector<int> CellsOf(const MovingSurface::Nodes& nodes,
                         const std::vector<std::array<int, 3>>& triangles) {
  std::vector<int> cell(triangles.size(), 0);
  std::vector<double> away(triangles.size(), std::numeric_limits<double>::infinity());
  std::size_t next = 0;
  for (int c = 0; c < kCells; ++c) {
    const Vector3d centre = nodes.col(triangles[next][0]);
    for (std::size_t k = 0; k < triangles.size(); ++k) {
      const double d = (nodes.col(triangles[k][0]) - centre).norm();
      if (d < away[k]) cell[k] = c, away[k] = d;
    }
    next = static_cast<std::size_t>(std::ranges::max_element(away) - away.begin());
  }
  return cell;
}

}  // namespace

CloudFit::CloudFit(const std::vector<Vector3d>& watched, std::vector<std::array<int, 3>> triangles,
                   double sigma)
    : rest_(AsMatrix(watched)),
      moved_(rest_),
      surface_(rest_, std::move(triangles)),
      sigma_(sigma),
      cell_(CellsOf(rest_, surface_.triangles())),
      by_force_(PatchGreens::kColumns, rest_.size()),
      sums_(kCells, 0) {}

void CloudFit::Deform(const PatchGreens::Field& field, const LoadVector& u) noexcept {
  const Eigen::Vector3f force = u.head<3>().cast<float>();
  Columns z;
  z << 1, u.tail<kLoadUnknowns - 3>().cast<float>();
  for (Eigen::Index i = 0; i < rest_.cols(); ++i) {
    for (int r = 0; r < 3; ++r) {
      const Columns by = field.middleCols<3>(9 * i + Eigen::Index{3} * r) * force;
      by_force_.col(3 * i + r) = by;
      moved_(r, i) = rest_(r, i) + by.dot(z);
    }
  }
  surface_.Move(moved_);
}

double CloudFit::Scatter() noexcept {
  sorted_.clear();
  for (const auto& place : places_) {
    if (place.triangle >= 0 && !place.at_border) sorted_.push_back(std::abs(place.height));
  }
  if (sorted_.empty()) return sigma_;
  return std::max(sigma_, SigmaOfSizes(sorted_));
}

const CloudSquares& CloudFit::Linearise(std::span<const Vector3d> points_O,
                                        const PatchGreens::Field& field,
                                        const LoadVector& u) noexcept {
  Deform(field, u);
  places_.clear();
  for (const Vector3d& y : points_O) places_.push_back(surface_.Nearest(y));
  squares_ = {};
  squares_.scatter = Scatter();
  Columns z;
  z << 1, u.tail<kLoadUnknowns - 3>().cast<float>();
  for (const auto& place : places_) {
    squares_.distance += place.distance * place.distance;
    if (place.triangle < 0 || place.at_border) continue;
    const double e = place.height / squares_.scatter;
    Add(place, field, z, 1 / (1 + e * e / (kBends * kBends)));
  }
  const int used = std::max(1, squares_.used);
  squares_.rms = std::sqrt(squares_.rms / used);
  squares_.moved = std::sqrt(squares_.moved / used);
  squares_.distance =
      std::sqrt(squares_.distance / std::max(1.0, static_cast<double>(places_.size())));
  squares_.H.triangularView<Eigen::StrictlyLower>() = squares_.H.transpose();
  Cluster();
  return squares_;
}

void CloudFit::Add(const MovingSurface::Place& place, const PatchGreens::Field& field,
                   const Columns& z, double weight) noexcept {
  const auto& t = surface_.triangles()[Index(place.triangle)];
  Eigen::Matrix<float, PatchGreens::kColumns, 3> along =
      Eigen::Matrix<float, PatchGreens::kColumns, 3>::Zero();  // n . B_k, per column of the force
  Columns by = Columns::Zero();
  Vector3d moved = Vector3d::Zero();
  for (int corner = 0; corner < 3; ++corner) {
    const Eigen::Index node = t[Index(corner)];
    const double share = place.weights[corner];
    moved += share * (moved_.col(node) - rest_.col(node));
    for (int r = 0; r < 3; ++r) {
      const auto part = static_cast<float>(share * place.n_O[r]);
      along += part * field.middleCols<3>(9 * node + Eigen::Index{3} * r);
      by += part * by_force_.col(3 * node + r);
    }
  }
  LoadVector J;
  J << (along.transpose() * z).cast<double>(), by.tail<PatchGreens::kColumns - 1>().cast<double>();
  J /= squares_.scatter;
  squares_.H.selfadjointView<Eigen::Upper>().rankUpdate(J, weight);
  squares_.g += weight * place.height / squares_.scatter * J;
  squares_.rms += place.height * place.height;
  squares_.moved += moved.squaredNorm();
  ++squares_.used;
}

// The sum's variance within cells over that of points that err on their own.
void CloudFit::Cluster() noexcept {
  std::ranges::fill(sums_, 0);
  double alone = 0, together = 0;
  for (const auto& place : places_) {
    if (place.triangle < 0 || place.at_border) continue;
    const double e = std::clamp(place.height / squares_.scatter, -kBends, kBends);
    sums_[Index(cell_[Index(place.triangle)])] += e;
    alone += e * e;
  }
  for (const double sum : sums_) together += sum * sum;
  if (alone > 0) squares_.effect = std::max(1.0, together / alone);
}

}  // namespace palpate
