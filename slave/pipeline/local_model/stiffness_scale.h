// What a felt force says of a modelled one: their ratio, which sizes the contact that the master
// renders by itself.
#pragma once

#include <Eigen/Core>

namespace palpate {

inline constexpr double kTellingDepth = 0.1;  // of the full depth: shallower says nothing of it

// What one sample says of the ratio felt / modelled [-].
struct RatioSample {
  double ratio = 1;  // within 0.25 to 4: more is a wrong model or a wrong pose, not a stiffness
  double error = 0;  // three standard deviations of the felt force, by that force
  bool tells = false;
};

// `felt`, `modelled`: sizes of the force [N]; `sigma` of the felt one. Only finite forces above
// zero tell.
RatioSample CompareForces(double felt, double sigma, double modelled) noexcept;

// Of the way to what one sample says, at `rate` samples a second, so that 1 / e is left after
// `time` [s].
double LearningRate(double time, double rate);

// The ratio as a function of depth, which a law that stiffens too much or too little needs. Values
// at depths 0 to full_depth, linear between them and constant beyond, by a Kalman filter:
// neighbours are taken to be alike until they are felt themselves, a sample has the less say the
// larger its error, never more than `learning_rate`; what was learnt long ago counts less.
class StiffnessScale {
 public:
  // `full_depth` [m] > 0; `learning_rate` in (0, 1]; `spread` > 0: the ratio's standard deviation
  // about 1 before anything was felt.
  StiffnessScale(double full_depth, double learning_rate, double spread) noexcept;

  void Learn(double depth, const RatioSample& sample) noexcept;
  struct Value {
    double ratio = 1, slope = 0;  // [-], by depth [1/m]
  };
  [[nodiscard]] Value At(double depth) const noexcept;
  // A modelled press of this force [N] and stiffness [N/m], sized as it was felt at its depth:
  // force and slope there, the latter not less than half of what the ratio alone makes of it.
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
  Covariance before_;  // of the ratios before anything was felt
  Values ratios_;
  Covariance covariance_;
};

}  // namespace palpate
