// Least squares with exclusion of outliers, and the uncertainty of a fitted pose.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {

struct CameraGuess {
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();
  double pixel = 0;  // [m]
};

struct RobustFit {
  CameraGuess guess;
  std::vector<double> residuals;  // for every position
  std::vector<bool> used;
};

using Indices = std::vector<std::size_t>;
// The best guess from some positions; nullopt: they determine none.
using SolveFor = std::function<std::optional<CameraGuess>(const Indices&)>;
// Residual of position `i`; NaN if unknown.
using MissOf = std::function<double(const CameraGuess&, std::size_t i)>;

// Least median of squares over subsets of `fewest` of the `usable` positions (fixed seed), then
// least squares of those within three robust sigma (Rousseeuw and Leroy, Robust Regression and
// Outlier Detection, 1987, ch. 5). With fewer than fewest + 2 usable positions all of them are
// used. nullopt: they determine no guess.
std::optional<RobustFit> FitRobustly(std::size_t count, const Indices& usable, std::size_t fewest,
                                     const SolveFor& solve, const MissOf& miss);

// How uncertain a fitted pose is, from what the fit leaves over: least squares of residuals that
// move with a small turn (first three columns of their Jacobian [rad]) and shift (last three [m])
// of the pose, whose noise is one unknown variance times a known covariance for each of them. With
// J the Jacobians, H = J (J^T J)^-1 J^T and C the covariances:
//   variance = (sum of squares) / tr((1 - H) C),   cov = variance (J^T J)^-1 J^T C J (J^T J)^-1
// and as many degrees of freedom as have the sum's mean and variance (Satterthwaite, Biometrics
// Bulletin 2, 1946). Few of them make the variance itself uncertain: the sigmas are widened to what
// holds 68.3 % of Student's distribution.
class PoseNoise {
 public:
  using Jacobian = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 3, 6>;
  using Covariance = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;

  // One position: Jacobian of its two or three residuals, and their covariance up to the variance.
  void Add(const Jacobian& J, const Covariance& C);

  struct Sigmas {
    double angle = 0;  // of the least certain axis [rad]
    double place = 0;  // in the least certain direction [m]
  };
  // Infinite if the positions determine no pose, or have no redundancy.
  [[nodiscard]] Sigmas Of(double sum_of_squares) const;

 private:
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  Matrix6 normal_ = Matrix6::Zero();  // J^T J
  Matrix6 noisy_ = Matrix6::Zero();   // J^T C J
  Matrix6 square_ = Matrix6::Zero();  // J^T C^2 J
  double trace_ = 0, square_trace_ = 0;
};

// Half width of the interval with 68.3 % of Student's distribution (Abramowitz and Stegun, Handbook
// of Mathematical Functions, 26.7.5, at one sigma): 2 % low at one degree of freedom, exact to 1 %
// from two on.
double StudentOneSigma(double degrees_of_freedom);

}  // namespace palpate
