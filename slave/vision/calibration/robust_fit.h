// Least squares that leaves out what contradicts the rest.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

namespace palpate {

struct CameraGuess {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();
  double pixel = 0;  // [m]
};

struct RobustFit {
  CameraGuess guess;
  std::vector<double> residuals;  // of every place
  std::vector<bool> used;
};

using Indices = std::vector<std::size_t>;
// The best guess from some places; nullopt: they define none.
using SolveFor = std::function<std::optional<CameraGuess>(const Indices&)>;
// How far place `i` is off; NaN where it cannot say.
using MissOf = std::function<double(const CameraGuess&, std::size_t i)>;

// Least median of squares over subsets of `fewest` of the `usable` places (fixed seed), then least
// squares of what lies within three robust sigma (Rousseeuw and Leroy, Robust Regression and
// Outlier Detection, 1987, ch. 5). With fewer than fewest + 2 usable places all of them are used.
// nullopt: they define no guess.
std::optional<RobustFit> FitRobustly(std::size_t count, const Indices& usable, std::size_t fewest,
                                     const SolveFor& solve, const MissOf& miss);

}  // namespace palpate
