#include "slave/vision/calibration/robust_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "slave/statistics/robust.h"

namespace palpate {
namespace {

constexpr int kSubsets = 400;

// `fewest` of `usable`, drawn without return.
Indices Draw(Indices usable, std::size_t fewest, std::mt19937* random) {
  for (std::size_t i = 0; i < fewest; ++i) {
    std::swap(usable[i], usable[i + (*random)() % (usable.size() - i)]);
  }
  usable.resize(fewest);
  return usable;
}

double MedianMiss(const CameraGuess& guess, const Indices& usable, std::size_t fewest,
                  const MissOf& miss) {
  std::vector<double> misses;
  for (const std::size_t i : usable) {
    const double m = miss(guess, i);
    misses.push_back(std::isfinite(m) ? m : std::numeric_limits<double>::infinity());
  }
  // What the subset fits exactly does not count as agreement.
  const std::size_t h = std::min((usable.size() + fewest + 1) / 2, usable.size() - 1);
  const auto middle = misses.begin() + static_cast<std::ptrdiff_t>(h);
  std::nth_element(misses.begin(), middle, misses.end());
  return *middle;
}

std::optional<std::pair<CameraGuess, double>> LeastMedian(const Indices& usable, std::size_t fewest,
                                                          const SolveFor& solve,
                                                          const MissOf& miss) {
  std::optional<std::pair<CameraGuess, double>> best;
  std::mt19937 random(1987);
  for (int k = 0; k < kSubsets; ++k) {
    const auto guess = solve(Draw(usable, fewest, &random));
    if (!guess) continue;
    const double median = MedianMiss(*guess, usable, fewest, miss);
    if (!best || median < best->second) best = {*guess, median};
  }
  return best;
}

double LargestSigma(const Eigen::Matrix3d& covariance) {
  if (!covariance.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(covariance, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, solver.eigenvalues()[2]));
}

}  // namespace

std::optional<RobustFit> FitRobustly(std::size_t count, const Indices& usable, std::size_t fewest,
                                     const SolveFor& solve, const MissOf& miss) {
  Indices chosen = usable;
  if (usable.size() >= fewest + 2) {
    const auto start = LeastMedian(usable, fewest, solve, miss);
    if (!start) return std::nullopt;
    const auto spare = static_cast<double>(usable.size() - fewest);
    const double limit = 3 * kSigmaPerMedian * (1 + 5 / spare) * start->second + 1e-12;
    chosen.clear();
    for (const std::size_t i : usable) {
      if (miss(start->first, i) <= limit) chosen.push_back(i);
    }
  }
  const auto guess = solve(chosen);
  if (!guess) return std::nullopt;
  RobustFit out{*guess, std::vector<double>(count, std::numeric_limits<double>::quiet_NaN()),
                std::vector<bool>(count, false)};
  for (const std::size_t i : usable) out.residuals[i] = miss(*guess, i);
  for (const std::size_t i : chosen) out.used[i] = true;
  return out;
}

void PoseNoise::Add(const Jacobian& J, const Covariance& C) {
  normal_ += J.transpose() * J;
  noisy_ += J.transpose() * C * J;
  square_ += J.transpose() * C * C * J;
  trace_ += C.trace();
  square_trace_ += (C * C).trace();
}

PoseNoise::Sigmas PoseNoise::Of(double sum_of_squares) const {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Eigen::FullPivLU<Matrix6> lu(normal_);
  if (!lu.isInvertible()) return {kInfinite, kInfinite};
  const Matrix6 inverse = lu.inverse();
  const Matrix6 taken = inverse * noisy_;  // what the fit takes of the noise
  const double left = trace_ - taken.trace();
  const double left_square =
      square_trace_ - 2 * (inverse * square_).trace() + (taken * taken).trace();
  if (!(left > 1e-9 * trace_) || !(left_square > 0)) return {kInfinite, kInfinite};
  const double widen = StudentOneSigma(left * left / left_square);
  const Matrix6 covariance = widen * widen * sum_of_squares / left * (taken * inverse);
  return {LargestSigma(covariance.topLeftCorner<3, 3>()),
          LargestSigma(covariance.bottomRightCorner<3, 3>())};
}

double StudentOneSigma(double degrees_of_freedom) {
  const double d = degrees_of_freedom;
  return 1 + 1 / (2 * d) + 1 / (4 * d * d) + 1 / (16 * d * d * d);
}

}  // namespace palpate
