#include "slave/tactile/training/optimiser.h"

#include <cmath>

namespace palpate {
namespace {

using Eigen::VectorXf;

class Sgd final : public Optimiser {
 public:
  void Step(double rate, const VectorXf& gradient, VectorXf* weights) override {
    *weights -= static_cast<float>(rate) * gradient;
  }
};

class Adam final : public Optimiser {
 public:
  explicit Adam(Eigen::Index weights)
      : mean_(VectorXf::Zero(weights)), square_(VectorXf::Zero(weights)) {}

  void Step(double rate, const VectorXf& gradient, VectorXf* weights) override {
    ++steps_;
    mean_ = kMeanDecay * mean_ + (1 - kMeanDecay) * gradient;
    square_ = kSquareDecay * square_ + (1 - kSquareDecay) * gradient.cwiseAbs2();
    // Both averages start at zero: early ones are raised to what they stand for.
    const double mean_share = 1 - std::pow(static_cast<double>(kMeanDecay), steps_);
    const double square_share = 1 - std::pow(static_cast<double>(kSquareDecay), steps_);
    const auto step = static_cast<float>(rate / mean_share);
    const auto raise = static_cast<float>(1 / square_share);
    weights->array() -= step * mean_.array() / ((raise * square_.array()).sqrt() + kFloor);
  }

 private:
  static constexpr float kMeanDecay = 0.9F, kSquareDecay = 0.999F, kFloor = 1e-8F;
  int steps_ = 0;
  VectorXf mean_, square_;
};

}  // namespace

std::unique_ptr<Optimiser> MakeSgd() {
  return std::make_unique<Sgd>();
}

std::unique_ptr<Optimiser> MakeAdam(Eigen::Index weights) {
  return std::make_unique<Adam>(weights);
}

}  // namespace palpate
