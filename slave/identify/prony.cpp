#include "slave/identify/prony.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "shared/text/text.h"

namespace palpate::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPerDecade = 2;
constexpr int kMostSweeps = 20'000;
constexpr double kSettled = 1e-10;    // of the largest modulus, in a sweep
constexpr double kNegligible = 1e-3;  // of the sum: such a term is left out

// Times two per decade; the last is short enough for the record to tell it from what stays.
std::vector<double> Times(const std::vector<RelaxationTable>& tables) {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  for (const RelaxationTable& table : tables) {
    for (std::size_t i = 1; i < table.time.size(); ++i) {
      const double step = table.time[i] - table.time[i - 1];
      if (step > 0) shortest = std::min(shortest, step);
    }
    longest = std::max(longest, table.time.back() - table.time.front());
  }
  std::vector<double> times;
  const int count = static_cast<int>(kPerDecade * std::log10(longest / 3 / shortest));
  for (int i = 0; i <= std::max(0, count); ++i) {
    times.push_back(shortest * std::pow(10, i / kPerDecade));
  }
  return times;
}

// What a modulus of one with this time answers to the strain, straight between the rows. The strain
// before the first row is zero.
VectorXd Branch(const RelaxationTable& table, double time) {
  VectorXd stress(static_cast<Index>(table.time.size()));
  double branch = table.strain.front();
  stress[0] = branch;
  for (std::size_t i = 1; i < table.time.size(); ++i) {
    const double x = (table.time[i] - table.time[i - 1]) / time;
    const double fade = std::exp(-x), rise = x > 1e-9 ? -std::expm1(-x) / x : 1;
    branch = fade * branch + rise * (table.strain[i] - table.strain[i - 1]);
    stress[static_cast<Index>(i)] = branch;
  }
  return stress;
}

// Coordinate by coordinate: convex, so that it ends at the least squares with none negative.
VectorXd SolveNonNegative(const MatrixXd& H, const VectorXd& g) {
  VectorXd x = VectorXd::Zero(g.size());
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double moved = 0;
    for (Index i = 0; i < x.size(); ++i) {
      const double next = std::max(0.0, x[i] + (g[i] - H.row(i).dot(x)) / H(i, i));
      moved = std::max(moved, std::abs(next - x[i]));
      x[i] = next;
    }
    if (moved <= kSettled * x.maxCoeff()) break;
  }
  return x;
}

struct Regression {
  MatrixXd A;  // last column: what stays
  VectorXd b;
};

Regression Stack(const std::vector<RelaxationTable>& tables, const std::vector<double>& times) {
  Index rows = 0;
  for (const RelaxationTable& table : tables) rows += static_cast<Index>(table.time.size());
  Regression all{MatrixXd(rows, static_cast<Index>(times.size()) + 1), VectorXd(rows)};
  Index at = 0;
  for (const RelaxationTable& table : tables) {
    const auto count = static_cast<Index>(table.time.size());
    for (std::size_t k = 0; k < times.size(); ++k) {
      all.A.col(static_cast<Index>(k)).segment(at, count) = Branch(table, times[k]);
    }
    all.A.rightCols(1).middleRows(at, count) =
        Eigen::Map<const VectorXd>(table.strain.data(), count);
    all.b.segment(at, count) = Eigen::Map<const VectorXd>(table.stress.data(), count);
    at += count;
  }
  return all;
}

}  // namespace

PronyFit FitProny(const std::vector<RelaxationTable>& tables) {
  std::vector<double> times = Times(tables);
  Regression data = Stack(tables, times);
  if (!(data.A.rightCols(1).norm() > 0) || !(data.b.norm() > 0)) {
    throw InputError(tables.front().name +
                     ": the strain is zero: accepted is a strain and its stress");
  }
  VectorXd x = SolveNonNegative(data.A.transpose() * data.A, data.A.transpose() * data.b);
  std::vector<Index> used;
  std::vector<double> kept;
  for (Index i = 0; i < x.size(); ++i) {
    const bool last = i + 1 == x.size();
    if (!last && x[i] < kNegligible * x.sum()) continue;
    used.push_back(i);
    if (!last) kept.push_back(times[static_cast<std::size_t>(i)]);
  }
  const MatrixXd A = data.A(Eigen::all, used);
  const MatrixXd H = A.transpose() * A;
  x = SolveNonNegative(H, A.transpose() * data.b);
  const VectorXd fitted = A * x;
  const VectorXd left = fitted - data.b;
  PronyFit fit{.rms = std::sqrt(left.squaredNorm() / static_cast<double>(left.size())) /
                      data.b.cwiseAbs().maxCoeff(),
               .fitted = {fitted.begin(), fitted.end()}};
  const VectorXd sigma = (left.squaredNorm() / static_cast<double>(left.size()) *
                          H.ldlt().solve(MatrixXd::Identity(H.rows(), H.cols())).diagonal())
                             .cwiseMax(0)
                             .cwiseSqrt();
  for (std::size_t i = 0; i < kept.size(); ++i) {
    fit.terms.push_back({x[static_cast<Index>(i)], sigma[static_cast<Index>(i)], kept[i]});
  }
  fit.equilibrium = x[x.size() - 1], fit.sigma = sigma[x.size() - 1];
  fit.instant = x.sum();
  return fit;
}

}  // namespace palpate::identify
