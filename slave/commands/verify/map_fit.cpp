#include "slave/commands/verify/map_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kLeastShare = 0.2;    // of the largest direction's size that a direction needs
constexpr double kNearlyWhole = 0.98;  // of an axis that lies in the tested directions
constexpr double kTie = 0.02;          // cosines that differ less are equally good
constexpr int kDraws = 400;

// Every relation that keeps the axes that are not in `axes`, the simplest ones first.
std::vector<AxisRelation> Relations(const std::vector<int>& axes) {
  struct Rated {
    AxisRelation relation;
    int cost;
  };
  std::vector<Rated> rated;
  std::vector<int> order = axes;
  const auto flips_end = 1U << axes.size();
  do {
    for (unsigned flips = 0; flips < flips_end; ++flips) {
      Rated one{{}, 0};
      for (std::size_t k = 0; k < axes.size(); ++k) {
        const auto j = static_cast<std::size_t>(axes[k]);
        one.relation.axis[j] = order[k];
        one.relation.sign[j] = (flips >> k & 1U) != 0 ? -1 : 1;
        one.cost += (order[k] != axes[k] ? 2 : 0) + (one.relation.sign[j] < 0 ? 2 : 0);
      }
      // Both a sign that is reversed everywhere, and one axis that is, are one mistake.
      if (flips + 1 == flips_end && !one.relation.is_permuted()) one.cost = 1;
      rated.push_back(one);
    }
  } while (std::ranges::next_permutation(order).found);
  std::ranges::stable_sort(rated, {}, &Rated::cost);
  std::vector<AxisRelation> relations;
  for (const Rated& one : rated) relations.push_back(one.relation);
  return relations;
}

struct Problem {
  MatrixXd U;  // 3 x directions: an orthonormal basis of those that the loads test
  MatrixXd K;  // weighted squares of the known vectors in that basis
  std::vector<AxisRelation> relations;
};

double Cosine(const Problem& p, const MatrixXd& X, const Matrix3d& relation) {
  const double reported = (X * p.K * X.transpose()).trace(), known = p.K.trace();
  if (!(reported > 0)) return 0;
  return (X.transpose() * relation * p.U * p.K).trace() / std::sqrt(reported * known);
}

std::size_t BestRelation(const Problem& p, const MatrixXd& X) {
  std::size_t best = 0;
  double highest = -2;
  for (std::size_t i = 0; i < p.relations.size(); ++i) {
    const double cosine = Cosine(p, X, p.relations[i].matrix());
    if (cosine > highest + kTie) highest = cosine, best = i;
  }
  return best;
}

double Gain(const Problem& p, const MatrixXd& X) {
  return Eigen::JacobiSVD<MatrixXd>(X * p.K).singularValues().sum() / p.K.trace();
}

double Turn(const Problem& p, const MatrixXd& X, const Matrix3d& relation) {
  const Eigen::JacobiSVD<MatrixXd> svd(relation.transpose() * X,
                                       Eigen::ComputeThinU | Eigen::ComputeThinV);
  const MatrixXd moved = svd.matrixU() * svd.matrixV().transpose() - p.U;
  const double chord = Eigen::JacobiSVD<MatrixXd>(moved).singularValues()(0);
  return 2 * std::asin(std::min(1.0, chord / 2));
}

template <class Statistic>
Interval Percentiles(const MatrixXd& X, const std::vector<MatrixXd>& draws,
                     const Statistic& statistic) {
  std::vector<double> values;
  for (const MatrixXd& draw : draws) values.push_back(statistic(draw));
  std::ranges::sort(values);
  const std::size_t tail = values.size() / 40;
  return {statistic(X), values[tail], values[values.size() - 1 - tail]};
}

// The angle that the truth may have: the estimate of an angle is never negative, so that noise
// moves it up.
Interval TurnInterval(const Problem& p, const MatrixXd& X, const std::vector<MatrixXd>& draws,
                      const Matrix3d& relation) {
  std::vector<double> errors;
  Problem from = p;
  from.U = relation.transpose() * X;
  const Eigen::JacobiSVD<MatrixXd> svd(from.U, Eigen::ComputeThinU | Eigen::ComputeThinV);
  from.U = svd.matrixU() * svd.matrixV().transpose();
  for (const MatrixXd& draw : draws) errors.push_back(Turn(from, draw, relation));
  std::ranges::sort(errors);
  const double angle = Turn(p, X, relation), reach = errors[errors.size() - 1 - errors.size() / 20];
  return {angle, std::fmax(0, angle - reach), std::fmin(std::numbers::pi, angle + reach)};
}

}  // namespace

Matrix3d AxisRelation::matrix() const {
  Matrix3d matrix = Matrix3d::Zero();
  for (std::size_t j = 0; j < 3; ++j) matrix(axis[j], static_cast<Eigen::Index>(j)) = sign[j];
  return matrix;
}

MapFit FitMap(const std::vector<KnownAndReported>& loads, const std::vector<int>& axes,
              double repeats) {
  MapFit fit{.loads = static_cast<int>(loads.size())};
  const auto count = static_cast<Eigen::Index>(loads.size());
  MatrixXd known = MatrixXd::Zero(3, count), reported = known;
  Eigen::VectorXd weight(count);
  double largest = 0;
  for (const auto& load : loads) largest = std::fmax(largest, load.known.norm());
  if (!(largest > 0) || axes.empty()) return fit;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto& load = loads[static_cast<std::size_t>(i)];
    for (const int axis : axes) {
      known(axis, i) = load.known(axis);
      reported(axis, i) = load.reported(axis);
    }
    // A load counts as no more accurate than 2 % of the largest.
    weight(i) = 1 / (load.sigma * load.sigma + 4e-4 * largest * largest);
  }
  weight /= weight.mean();
  const auto W = weight.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(known * W * known.transpose());
  const double most = eigen.eigenvalues()(2);
  fit.directions =
      static_cast<int>((eigen.eigenvalues().array() >= kLeastShare * kLeastShare * most).count());
  Problem p{eigen.eigenvectors().rightCols(fit.directions), {}, Relations(axes)};
  const MatrixXd inside = p.U.transpose() * known;
  p.K = inside * W * inside.transpose();
  const MatrixXd spread = p.K.inverse();
  const MatrixXd X = reported * W * inside.transpose() * spread;
  fit.map = X * p.U.transpose();
  const MatrixXd residual = reported - X * inside;
  const double all = (reported * W * reported.transpose()).trace();
  if (!(all > 1e-18 * eigen.eigenvalues().sum())) {  // nothing but rounding errors
    fit.directions = 0;
    return fit;
  }
  fit.explained = 1 - (residual * W * residual.transpose()).trace() / all;
  const double freedom = static_cast<double>(count) / repeats - fit.directions;
  fit.is_decided = freedom >= 2;
  const std::size_t best = BestRelation(p, X);
  fit.relation = p.relations[best];
  if (!fit.is_decided) return fit;

  const Vector3d deviation =
      ((residual * W * residual.transpose()).diagonal().array() / freedom).max(0).sqrt();
  const double reach = StudentReach(freedom);
  fit.half_width = reach * deviation *
                   (p.U * spread * p.U.transpose()).diagonal().cwiseMax(0).cwiseSqrt().transpose();
  const MatrixXd root = spread.llt().matrixL();
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, reach / StudentReach(1e9));
  std::vector<MatrixXd> draws;
  for (int i = 0; i < kDraws; ++i) {
    const MatrixXd noise = MatrixXd::NullaryExpr(3, fit.directions, [&] { return normal(random); });
    draws.emplace_back(X + deviation.asDiagonal() * noise * root.transpose());
  }
  const Matrix3d relation = fit.relation.matrix();
  fit.gain = Percentiles(X, draws, [&](const MatrixXd& x) { return Gain(p, x); });
  fit.along =
      Percentiles(X, draws, [&](const MatrixXd& x) { return Cosine(p, x, Matrix3d::Identity()); });
  fit.turn = TurnInterval(p, X, draws, relation);
  for (std::size_t j = 0; j < 3; ++j) {
    const Eigen::VectorXd axis = p.U.row(static_cast<Eigen::Index>(j)).transpose();
    if (axis.norm() < kNearlyWhole) continue;
    fit.axis_gain[j] = Percentiles(X, draws, [&](const MatrixXd& x) { return (x * axis).norm(); });
  }
  const auto as_best = std::ranges::count_if(
      draws, [&](const MatrixXd& x) { return (BestRelation(p, x) == 0) == (best == 0); });
  fit.relation_is_clear = as_best >= kDraws - kDraws / 20;
  return fit;
}

}  // namespace palpate
