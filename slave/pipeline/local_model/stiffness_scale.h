// Ratio of estimated to modelled force, which scales the local contact model.
#pragma once

#include <Eigen/Core>

namespace palpate {

// Smallest informative depth, relative to the full depth [-]. [tuned:
// FlaggedAndForeignLoadsAreNotLearnt]
inline constexpr double kInformativeDepth = 0.1;

// Information of one sample about the ratio estimated / modelled [-].
struct RatioSample {
  double ratio = 1;  // limited to 0.25 to 4, because other values indicate a wrong model or pose
  double error = 0;  // three standard deviations of the estimated force, relative to that force
  bool is_informative = false;
};

// `sensed`, `modelled`: magnitudes of the force [N]; `sigma` of the estimated one. Only finite
// forces above zero count.
RatioSample CompareForces(double sensed, double sigma, double modelled) noexcept;

// Returns the weight of one sample, at `rate` samples per second, so that 1 / e of a difference
// remains after `time` [s].
double LearningRate(double time, double rate);

// The ratio as a function of depth, for models that stiffen too much or too little. Values at
// depths 0 to full_depth, linear between and constant beyond, by a Kalman filter: neighbours are
// assumed equal until they are measured, the weight of a sample decreases with its error and is at
// most `learning_rate`, and old samples have less weight.
class StiffnessScale {
 public:
  // `full_depth` [m] > 0; `learning_rate` in (0, 1]; `spread` > 0: initial standard deviation of
  // the ratio about 1.
  StiffnessScale(double full_depth, double learning_rate, double spread) noexcept;

  void Learn(double depth, const RatioSample& sample) noexcept;
  struct Value {
    double ratio = 1, slope = 0;  // [-], by depth [1/m]
  };
  [[nodiscard]] Value At(double depth) const noexcept;
  // A modelled force [N] and stiffness [N/m], scaled by the estimate at its depth: force and slope
  // at that depth; the slope is at least half of the model's stiffness times the ratio.
  struct Press {
    double force = 0, stiffness = 0;
  };
  [[nodiscard]] Press Scaled(const Press& modelled, double depth) const noexcept;
  void Forget() noexcept;

 private:
  static constexpr int kDepths = 6;
  using Values = Eigen::Matrix<double, kDepths, 1>;
  using Covariance = Eigen::Matrix<double, kDepths, kDepths>;
  [[nodiscard]] Values Weights(double depth) const noexcept;

  double full_depth_, learning_rate_;
  Covariance before_;  // initial covariance of the ratios
  Values ratios_;
  Covariance covariance_;
};

}  // namespace palpate
