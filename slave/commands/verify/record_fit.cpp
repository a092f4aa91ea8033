#include "slave/commands/verify/record_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Index kFewestRows = 50;
constexpr double kLongestDelay = 1;  // [s]

// How many neighbouring rows share their errors: from the spread of means of blocks, which is that
// of single rows over the root of their number if each row has its own error.
double Repeats(const Matrix3Xd& residual) {
  constexpr Index kBlocks = 20, kShortestBlock = 4;
  const Index blocks = std::min(kBlocks, residual.cols() / kShortestBlock);
  if (blocks < 5) return 1;
  const Index length = residual.cols() / blocks;
  double of_means = 0;
  for (Index b = 0; b < blocks; ++b) {
    of_means += residual.middleCols(b * length, length).rowwise().mean().squaredNorm();
  }
  const double of_rows = residual.squaredNorm() / static_cast<double>(residual.cols());
  if (!(of_rows > 0)) return 1;
  return std::max(1.0,
                  static_cast<double>(length) * of_means / static_cast<double>(blocks) / of_rows);
}

Matrix3Xd Centred(const Matrix3Xd& vectors) {
  return vectors.colwise() - vectors.rowwise().mean();
}

// The known force at `t`, from the row `*at` on, which moves on with the time. `t`: within the
// record.
Vector3d KnownAt(const ForceRecord& record, double t, Index* at) {
  while (*at + 2 < record.t.size() && record.t(*at + 1) < t) ++*at;
  const double from = record.t(*at), until = record.t(*at + 1);
  const double share = until > from ? (t - from) / (until - from) : 0;
  return record.known.col(*at) + share * (record.known.col(*at + 1) - record.known.col(*at));
}

// Errors of linear maps with delays.
class DelaySearch {
 public:
  DelaySearch(const ForceRecord& record, double reach)
      : record_(record), directions_(TestedDirections(record.known)) {
    const double begin = record.t(0) + reach, end = record.t(record.t.size() - 1) - reach;
    for (Index i = 0; i < record.t.size(); ++i) {
      if (record.t(i) >= begin && record.t(i) <= end) rows_.push_back(i);
    }
    reported_.resize(3, rows());
    for (Index i = 0; i < rows(); ++i) reported_.col(i) = record.reported.col(row(i));
    reported_ = Centred(reported_);
  }
  [[nodiscard]] Index rows() const { return static_cast<Index>(rows_.size()); }
  [[nodiscard]] bool is_possible() const { return rows() >= kFewestRows && directions_.cols() > 0; }
  [[nodiscard]] Matrix3Xd Residual(double delay) const {
    Matrix3Xd known(3, rows());
    Index at = 0;
    for (Index i = 0; i < rows(); ++i)
      known.col(i) = KnownAt(record_, record_.t(row(i)) - delay, &at);
    const MatrixXd inside = directions_.transpose() * Centred(known);
    const MatrixXd squares = inside * inside.transpose();
    return reported_ - reported_ * inside.transpose() * squares.ldlt().solve(inside);
  }
  [[nodiscard]] double Squares(double delay) const { return Residual(delay).squaredNorm(); }

 private:
  [[nodiscard]] Index row(Index i) const { return rows_[static_cast<std::size_t>(i)]; }

  const ForceRecord& record_;
  MatrixXd directions_;
  std::vector<Index> rows_;
  Matrix3Xd reported_;
};

// The minimum of a function between `low` and `high`, where it has one: golden section.
template <class Function>
double Minimum(const Function& f, double low, double high) {
  constexpr double kGolden = 0.6180339887498949;
  double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
  double fa = f(a), fb = f(b);
  for (int i = 0; i < 30; ++i) {
    if (fa < fb) {
      high = b, b = a, fb = fa, a = high - kGolden * (high - low), fa = f(a);
    } else {
      low = a, a = b, fa = fb, b = low + kGolden * (high - low), fb = f(b);
    }
  }
  return (low + high) / 2;
}

// +1 while the known force grows along its main direction, -1 while it falls, 0 while it rests.
VectorXd Loading(const Matrix3Xd& known, const Eigen::Vector3d& direction) {
  constexpr Index kLoadingSpan = 3;
  constexpr double kRestingShare = 0.1;  // of the fastest change
  const Index n = known.cols();
  VectorXd along = known.transpose() * direction;
  // Towards larger forces, whichever way the direction points.
  if (std::abs(along.minCoeff()) > std::abs(along.maxCoeff())) along = -along;
  VectorXd change(n);
  for (Index i = 0; i < n; ++i) {
    change(i) =
        along(std::min(n - 1, i + kLoadingSpan)) - along(std::max<Index>(0, i - kLoadingSpan));
  }
  const double fastest = change.cwiseAbs().maxCoeff();
  return change.unaryExpr([&](double x) {
    return std::abs(x) > kRestingShare * fastest ? std::copysign(1.0, x) : 0.0;
  });
}

}  // namespace

MatrixXd TestedDirections(const Matrix3Xd& known) {
  constexpr double kLeastDirection = 0.2;  // of the largest direction's size
  const Matrix3Xd centred = Centred(known);
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(centred * centred.transpose());
  const double most = eigen.eigenvalues()(2);
  if (!(most > 0)) return MatrixXd(3, 0);
  const Index count =
      (eigen.eigenvalues().array() >= kLeastDirection * kLeastDirection * most).count();
  return eigen.eigenvectors().rightCols(count).rowwise().reverse();
}

std::optional<Interval> EstimateDelay(const ForceRecord& record) {
  const Index n = record.t.size();
  if (n < kFewestRows) return std::nullopt;
  const double duration = record.t(n - 1) - record.t(0);
  const double reach = std::min(kLongestDelay, duration / 4);
  const DelaySearch search(record, reach);
  if (!(reach > 0) || !search.is_possible()) return std::nullopt;
  constexpr int kSteps = 60;
  const double step = reach / kSteps;
  int best = 0;
  double least = search.Squares(0);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double squares = search.Squares(i * step);
    if (squares < least) least = squares, best = i;
  }
  if (std::abs(best) == kSteps) return std::nullopt;
  const auto squares = [&](double delay) { return search.Squares(delay); };
  const double delay = Minimum(squares, (best - 1) * step, (best + 1) * step);
  const double curvature =
      (squares(delay - step) - 2 * squares(delay) + squares(delay + step)) / (step * step);
  const Matrix3Xd residual = search.Residual(delay);
  const double freedom = static_cast<double>(search.rows()) / Repeats(residual) - 5;
  if (!(curvature > 0) || freedom < 2) return std::nullopt;
  const double half =
      StudentReach(freedom) * std::sqrt(2 * residual.squaredNorm() / freedom / curvature);
  return Interval{delay, delay - half, delay + half};
}

void MoveKnown(double delay, ForceRecord* record, std::vector<std::size_t>* kept) {
  const ForceRecord before = *record;
  const std::vector<std::size_t> numbers = *kept;
  const Index n = before.t.size();
  Index at = 0, count = 0;
  kept->clear();
  for (Index i = 0; i < n; ++i) {
    const double t = before.t(i) - delay;
    if (t < before.t(0) || t > before.t(n - 1)) continue;
    record->known.col(count) = KnownAt(before, t, &at);
    record->reported.col(count) = before.reported.col(i);
    record->t(count++) = before.t(i);
    kept->push_back(numbers[static_cast<std::size_t>(i)]);
  }
  record->known.conservativeResize(3, count);
  record->reported.conservativeResize(3, count);
  record->t.conservativeResize(count);
}

RecordMap FitRecord(const ForceRecord& record, const std::vector<int>& axes) {
  const Matrix3Xd known = Centred(record.known), reported = Centred(record.reported);
  std::vector<KnownAndReported> forth, back;
  for (Index i = 0; i < known.cols(); ++i) {
    forth.push_back({known.col(i), reported.col(i), 0});
    back.push_back({reported.col(i), known.col(i), 0});
  }
  RecordMap fit;
  fit.repeats = Repeats(reported - FitMap(forth, axes).map * known);
  fit.forth = FitMap(forth, axes, fit.repeats);
  fit.back = FitMap(back, axes, fit.repeats);
  return fit;
}

RecordChange FitChange(const ForceRecord& record) {
  const Index n = record.t.size();
  const MatrixXd directions = TestedDirections(record.known);
  if (n < kFewestRows || directions.cols() == 0) return {};
  const double duration = record.t(n - 1) - record.t(0);
  MatrixXd terms(n, directions.cols() + 3);
  terms.leftCols(directions.cols()) = record.known.transpose() * directions;
  terms.col(directions.cols()).setOnes();
  terms.col(directions.cols() + 1) = (record.t.array() - record.t.mean()) / duration;
  terms.col(directions.cols() + 2) = Loading(record.known, directions.col(0));
  const Eigen::LDLT<MatrixXd> squares(terms.transpose() * terms);
  const MatrixXd solved = squares.solve(terms.transpose() * record.reported.transpose());
  const Matrix3Xd residual = record.reported - (terms * solved).transpose();
  const double freedom =
      static_cast<double>(n) / Repeats(residual) - static_cast<double>(terms.cols());
  const MatrixXd spread = squares.solve(MatrixXd::Identity(terms.cols(), terms.cols()));
  if (freedom < 2 || !(duration > 0) || !spread.allFinite()) return {};
  const auto size = [&](Index term, double scale) {
    const double value = solved.row(term).norm();
    const double half =
        StudentReach(freedom) * std::sqrt(residual.squaredNorm() / freedom * spread(term, term));
    return Interval{scale * value, scale * std::max(0.0, value - half), scale * (value + half)};
  };
  const Index drift = directions.cols() + 1;
  return {size(drift, 1), solved.row(drift).transpose(), size(drift + 1, 2)};
}

}  // namespace palpate
