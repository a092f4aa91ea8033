#include "slave/identify/prony.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "shared/text/text.h"
#include "slave/identify/specimen_spread.h"
#include "slave/mechanics/relaxation/prony_series.h"

namespace palpate::identify {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kPerDecade = 2;
constexpr int kMaxSweeps = 20'000;
constexpr double kSettled = 1e-10;        // change in one sweep relative to the largest modulus
constexpr double kNegligibleTerm = 1e-3;  // of the sum: such a term is left out
// Shares of the record [-]: a ramp takes 1 % of its record for 1 % of its strain [derived: steady
// rate].
constexpr double kStill = 0.01, kHold = 0.03;
constexpr double kReturn = 0.1;   // part of the range by which a strain must return [-]
constexpr double kOtherRate = 2;  // ratio of rates that differ [-]

// Returns two time constants per decade. The first is the usual step of the densest record, the
// last short enough to be distinguished from the remaining stress.
std::vector<double> Times(const std::vector<RelaxationTable>& tables) {
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  for (const RelaxationTable& table : tables) {
    std::vector<double> steps;
    for (std::size_t i = 1; i < table.time.size(); ++i) {
      const double step = table.time[i] - table.time[i - 1];
      if (step > 0) steps.push_back(step);
    }
    if (!steps.empty()) {
      std::ranges::nth_element(steps,
                               steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2));
      shortest = std::min(shortest, steps[steps.size() / 2]);
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

// Returns the stress of a unit modulus with this relaxation time under the strain, which is linear
// between the rows. The strain before the first row is zero.
VectorXd Branch(const RelaxationTable& table, double time) {
  VectorXd stress(static_cast<Index>(table.time.size()));
  double branch = table.strain.front();
  stress[0] = branch;
  for (std::size_t i = 1; i < table.time.size(); ++i) {
    const PronyStep step(table.time[i] - table.time[i - 1], time);
    branch = step.fade * branch + step.rise * (table.strain[i] - table.strain[i - 1]);
    stress[static_cast<Index>(i)] = branch;
  }
  return stress;
}

// Solves non-negative least squares by coordinate descent, which converges because the problem is
// convex.
VectorXd SolveNonNegative(const MatrixXd& H, const VectorXd& g) {
  VectorXd x = VectorXd::Zero(g.size());
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
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
  MatrixXd A;  // last column: the remaining stress
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

// Returns the strain rate during straining: the 90th percentile of the steps.
double RateOf(const RelaxationTable& table) {
  std::vector<double> rates;
  for (std::size_t i = 1; i < table.time.size(); ++i) {
    const double step = table.time[i] - table.time[i - 1];
    if (step > 0) rates.push_back(std::abs(table.strain[i] - table.strain[i - 1]) / step);
  }
  if (rates.empty()) return 0;
  std::ranges::sort(rates);
  return rates[(rates.size() - 1) * 9 / 10];
}

// Returns whether the strain is held for a while, or returns.
bool HoldsOrReturns(const RelaxationTable& table) {
  const auto [low, high] = std::ranges::minmax(table.strain);
  const double range = high - low, record = table.time.back() - table.time.front();
  double longest = 0, up = table.strain.front(), down = up, back = 0;
  std::size_t from = 0;
  for (std::size_t i = 0; i < table.time.size(); ++i) {
    while (std::abs(table.strain[i] - table.strain[from]) > kStill * range) ++from;
    longest = std::max(longest, table.time[i] - table.time[from]);
    up = std::max(up, table.strain[i]), down = std::min(down, table.strain[i]);
    back = std::max(back, std::min(up - table.strain[i], table.strain[i] - down));
  }
  return longest >= kHold * record || back >= kReturn * range;
}

void RequireFading(const std::vector<RelaxationTable>& tables) {
  double slowest = std::numeric_limits<double>::infinity(), fastest = 0;
  bool is_determined = false;
  for (const RelaxationTable& table : tables) {
    if (table.shear != tables.front().shear) {
      throw InputError(table.name + ": shear and other strains together: expected one of them");
    }
    const double rate = RateOf(table);
    slowest = std::min(slowest, rate), fastest = std::max(fastest, rate);
    is_determined |= HoldsOrReturns(table);
  }
  if (is_determined || fastest > kOtherRate * slowest) return;
  throw InputError(
      tables.front().name +
      ": the strain only rises, at one rate, so that fading cannot be separated from a curved "
      "stress-strain law: for relaxation, expected a strain that is held or returns, or records "
      "of several rates; for one ramp use tension, compression or shear");
}

struct Solution {
  VectorXd x;
  MatrixXd covariance;
};

Solution Solve(const MatrixXd& A, const VectorXd& b) {
  const MatrixXd H = A.transpose() * A;
  Solution solved{SolveNonNegative(H, A.transpose() * b), {}};
  const double variance = (A * solved.x - b).squaredNorm() / static_cast<double>(b.size());
  solved.covariance = variance * H.ldlt().solve(MatrixXd::Identity(H.rows(), H.cols()));
  return solved;
}

// Returns the branch whose interval includes zero, the least certain one if there are several.
std::optional<Index> SpansZero(const Solution& solved) {
  std::optional<Index> found;
  double least = kNormalWide;
  for (Index i = 0; i + 1 < solved.x.size(); ++i) {
    const double sure = solved.x[i] / std::sqrt(std::max(solved.covariance(i, i), 1e-300));
    if (sure <= least) least = sure, found = i;
  }
  return found;
}

PronyFit FitSeries(const std::vector<RelaxationTable>& tables) {
  const std::vector<double> times = Times(tables);
  const Regression data = Stack(tables, times);
  if (!(data.A.rightCols(1).norm() > 0) || !(data.b.norm() > 0)) {
    throw InputError(tables.front().name +
                     ": the strain is zero: expected a strain and its stress");
  }
  PronyFit fit;
  Solution solved{SolveNonNegative(data.A.transpose() * data.A, data.A.transpose() * data.b), {}};
  std::vector<Index> used;
  for (Index i = 0; i < solved.x.size(); ++i) {
    const bool last = i + 1 == solved.x.size();
    if (last || solved.x[i] >= kNegligibleTerm * solved.x.sum()) used.push_back(i);
  }
  solved = Solve(data.A(Eigen::all, used), data.b);
  while (const auto open = SpansZero(solved)) {
    fit.dropped += solved.x[*open] > 0 ? 1 : 0;
    used.erase(used.begin() + *open);
    solved = Solve(data.A(Eigen::all, used), data.b);
  }
  const VectorXd fitted = data.A(Eigen::all, used) * solved.x, left = fitted - data.b;
  fit.rms = std::sqrt(left.squaredNorm() / static_cast<double>(left.size())) /
            data.b.cwiseAbs().maxCoeff();
  const VectorXd sigma = solved.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  const Index last = solved.x.size() - 1;
  for (Index i = 0; i < last; ++i) {
    const double time = times[static_cast<std::size_t>(used[static_cast<std::size_t>(i)])];
    fit.terms.push_back({solved.x[i], sigma[i], time});
  }
  fit.equilibrium = solved.x[last], fit.sigma = sigma[last];
  fit.instant = solved.x.sum();
  return fit;
}

}  // namespace

double PronyFit::At(double time) const {
  double modulus = equilibrium;
  for (const PronyTerm& term : terms) modulus += term.modulus * std::exp(-time / term.time);
  return modulus;
}

PronyFit FitProny(const std::vector<RelaxationTable>& tables) {
  RequireFading(tables);
  return FitSeries(tables);
}

}  // namespace palpate::identify
