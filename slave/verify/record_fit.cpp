#include "slave/verify/record_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kMaxSearchedDelay = 1;  // [s]

Matrix3Xd Centred(const Matrix3Xd& vectors) {
  return vectors.colwise() - vectors.rowwise().mean();
}

Directions DirectionsOf(const Matrix3Xd& vectors) {
  const Matrix3Xd centred = Centred(vectors);
  return TestedDirections(centred * centred.transpose());
}

// Returns the measured force at `t`, which lies within the record. The search starts at the row
// `*at` and moves it on.
Vector3d MeasuredAt(const ForceRecord& record, double t, Index* at) {
  while (*at + 2 < record.t.size() && record.t(*at + 1) < t) ++*at;
  const double from = record.t(*at), until = record.t(*at + 1);
  const double share = until > from ? (t - from) / (until - from) : 0;
  return record.measured.col(*at) +
         share * (record.measured.col(*at + 1) - record.measured.col(*at));
}

// Computes the squared errors of linear maps with delays. It uses the rows whose measured force is
// known at every delay up to `reach`.
class DelaySearch {
 public:
  DelaySearch(const ForceRecord& record, double reach)
      : record_(record), directions_(DirectionsOf(record.measured)) {
    const double begin = record.t(0) + reach, end = record.t(record.t.size() - 1) - reach;
    for (Index i = 0; i < record.t.size(); ++i) {
      if (record.t(i) >= begin && record.t(i) <= end) rows_.push_back(i);
    }
    estimated_ = Centred(record.estimated(Eigen::all, rows_));
    block_ = BlocksOf(rows());
  }
  [[nodiscard]] Index rows() const { return static_cast<Index>(rows_.size()); }
  [[nodiscard]] bool is_possible() const { return rows() >= kMinFitRows && directions_.cols() > 0; }
  // Returns the sum of squares of each block of rows.
  [[nodiscard]] VectorXd Squares(double delay) const {
    Matrix3Xd measured(3, rows());
    Index at = 0;
    for (Index i = 0; i < rows(); ++i) {
      const double t = record_.t(rows_[static_cast<std::size_t>(i)]) - delay;
      measured.col(i) = MeasuredAt(record_, t, &at);
    }
    const MatrixXd inside = directions_.transpose() * Centred(measured);
    const MatrixXd squares = inside * inside.transpose();
    const Matrix3Xd error =
        estimated_ - estimated_ * inside.transpose() * squares.ldlt().solve(inside);
    VectorXd sums = VectorXd::Zero(block_.back() + 1);
    for (Index i = 0; i < rows(); ++i) {
      sums(block_[static_cast<std::size_t>(i)]) += error.col(i).squaredNorm();
    }
    return sums;
  }

 private:
  const ForceRecord& record_;
  Directions directions_;
  std::vector<Index> rows_;
  std::vector<int> block_;
  Matrix3Xd estimated_;
};

// Returns the place of the minimum of the parabola through three values at -1, 0 and 1.
double Vertex(double before, double at, double after) {
  return (before - after) / (2 * (before - 2 * at + after));
}

// Returns for each row +1 while the measured force grows along its main direction, -1 while it
// falls, 0 while it is constant.
VectorXd Loading(const Matrix3Xd& measured, const Vector3d& direction) {
  constexpr Index kSpan = 3;             // rows to either side
  constexpr double kRestingShare = 0.1;  // of the fastest change
  const Index n = measured.cols();
  VectorXd along = measured.transpose() * direction;
  // Makes the direction point towards larger forces.
  if (std::abs(along.minCoeff()) > std::abs(along.maxCoeff())) along = -along;
  VectorXd change(n);
  for (Index i = 0; i < n; ++i) {
    change(i) = along(std::min(n - 1, i + kSpan)) - along(std::max<Index>(0, i - kSpan));
  }
  const double fastest = change.cwiseAbs().maxCoeff();
  return change.unaryExpr([&](double x) {
    return std::abs(x) > kRestingShare * fastest ? std::copysign(1.0, x) : 0.0;
  });
}

}  // namespace

std::optional<Interval> EstimateDelay(const ForceRecord& record) {
  const Index n = record.t.size();
  if (n < kMinFitRows) return std::nullopt;
  const double reach = std::min(kMaxSearchedDelay, (record.t(n - 1) - record.t(0)) / 4);
  const DelaySearch search(record, reach);
  if (!(reach > 0) || !search.is_possible()) return std::nullopt;
  constexpr int kSteps = 60, kRefinements = 3;
  const double step = reach / kSteps;
  int best = 0;
  double least = search.Squares(0).sum();
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double squares = search.Squares(i * step).sum();
    if (squares < least) least = squares, best = i;
  }
  if (std::abs(best) == kSteps) return std::nullopt;
  double delay = best * step;
  VectorXd before, at, after;
  for (int i = 0; i < kRefinements; ++i) {
    before = search.Squares(delay - step);
    at = search.Squares(delay);
    after = search.Squares(delay + step);
    const double vertex = Vertex(before.sum(), at.sum(), after.sum());
    if (!(std::abs(vertex) <= 1)) return std::nullopt;
    delay = std::clamp(delay + step * vertex, step - reach, reach - step);
  }
  const double vertex = Vertex(before.sum(), at.sum(), after.sum());
  std::vector<double> without;
  for (Index b = 0; b < at.size(); ++b) {
    without.push_back(Vertex(before.sum() - before(b), at.sum() - at(b), after.sum() - after(b)));
  }
  const auto freedom = static_cast<double>(at.size()) - 1;
  const double half =
      step * JackknifeReach(without, freedom, [&](double one) { return one - vertex; });
  return Interval{delay, delay - half, delay + half};
}

std::vector<Index> MoveMeasured(double delay, ForceRecord* record) {
  const ForceRecord before = *record;
  const Index n = before.t.size();
  std::vector<Index> kept;
  for (Index i = 0; i < n; ++i) {
    const double t = before.t(i) - delay;
    if (t >= before.t(0) && t <= before.t(n - 1)) kept.push_back(i);
  }
  *record = {before.t(kept), before.measured(Eigen::all, kept), before.estimated(Eigen::all, kept)};
  Index at = 0;
  for (Index i = 0; i < record->t.size(); ++i) {
    record->measured.col(i) = MeasuredAt(before, record->t(i) - delay, &at);
  }
  return kept;
}

RecordChange FitChange(const ForceRecord& record) {
  const Index n = record.t.size();
  const Directions directions = DirectionsOf(record.measured);
  if (n < kMinFitRows || directions.cols() == 0 || !(record.t(n - 1) > record.t(0))) return {};
  const Index drift = directions.cols() + 1, loading = drift + 1;
  MatrixXd terms(n, loading + 1);
  terms.leftCols(directions.cols()) = record.measured.transpose() * directions;
  terms.col(directions.cols()).setOnes();
  terms.col(drift) = (record.t.array() - record.t.mean()) / (record.t(n - 1) - record.t(0));
  terms.col(loading) = Loading(record.measured, directions.col(0));
  const std::vector<int> block = BlocksOf(n);
  const auto blocks = static_cast<std::size_t>(block.back()) + 1;
  MatrixXd all_squares = MatrixXd::Zero(terms.cols(), terms.cols());
  MatrixXd all_products = MatrixXd::Zero(terms.cols(), 3);
  std::vector<MatrixXd> squares(blocks, all_squares), products(blocks, all_products);
  for (Index i = 0; i < n; ++i) {
    const auto b = static_cast<std::size_t>(block[static_cast<std::size_t>(i)]);
    squares[b] += terms.row(i).transpose() * terms.row(i);
    products[b] += terms.row(i).transpose() * record.estimated.col(i).transpose();
  }
  for (const MatrixXd& one : squares) all_squares += one;
  for (const MatrixXd& one : products) all_products += one;
  const MatrixXd solved = all_squares.ldlt().solve(all_products);
  std::vector<MatrixXd> without;
  for (std::size_t b = 0; b < blocks; ++b) {
    without.emplace_back((all_squares - squares[b]).ldlt().solve(all_products - products[b]));
  }
  const auto freedom = static_cast<double>(blocks) - 1;
  const auto size = [&](Index term, double scale) -> std::optional<Interval> {
    const double value = solved.row(term).norm();
    const double reach = JackknifeReach(without, freedom, [&](const MatrixXd& one) {
      return (one.row(term) - solved.row(term)).norm();
    });
    if (!std::isfinite(value + reach)) return std::nullopt;
    return Interval{scale * value, scale * std::max(0.0, value - reach), scale * (value + reach)};
  };
  return {size(drift, 1), solved.row(drift).transpose(), size(loading, 2)};
}

}  // namespace palpate
