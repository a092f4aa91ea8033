#include "slave/tactile/network/dense_stack.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace palpate {

DenseStack::DenseStack(const NetworkWeights& weights, double gain)
    : activation_(weights.activation) {
  for (const DenseLayer& layer : weights.dense) {
    const bool last = &layer == &weights.dense.back();
    Layer to{static_cast<std::size_t>(layer.kernel.rows()),
             static_cast<std::size_t>(layer.kernel.cols()),
             {},
             {}};
    const auto scale = [&](Eigen::Index j) {
      return last ? gain * static_cast<double>(weights.output_scale[j]) : 1.0;
    };
    for (Eigen::Index i = 0; i < layer.kernel.rows(); ++i) {
      for (Eigen::Index j = 0; j < layer.kernel.cols(); ++j) {
        to.kernel.push_back(scale(j) * static_cast<double>(layer.kernel(i, j)));
      }
    }
    for (Eigen::Index j = 0; j < layer.kernel.cols(); ++j) {
      const double mean = last ? gain * static_cast<double>(weights.output_mean[j]) : 0;
      to.bias.push_back(mean + scale(j) * static_cast<double>(layer.bias[j]));
    }
    widest_ = std::max(widest_, to.outputs);
    layers_.push_back(std::move(to));
  }
}

void DenseStack::Layer::Apply(const double* x, double* y) const noexcept {
  std::copy(bias.begin(), bias.end(), y);
  const double* row = kernel.data();
  for (std::size_t i = 0; i < inputs; ++i, row += outputs) {
    for (std::size_t j = 0; j < outputs; ++j) y[j] += x[i] * row[j];
  }
}

void DenseStack::Activate(std::span<double> y) const noexcept {
  for (double& value : y) {
    value = activation_ == HiddenActivation::kTanh ? std::tanh(value) : std::max(value, 0.0);
  }
}

bool DenseStack::Evaluate(const double* x, std::span<double> scratch,
                          std::span<double> outputs) const noexcept {
  assert(scratch.size() >= scratch_size() && outputs.size() == layers_.back().outputs);
  double* here = scratch.data();
  double* there = here + widest_;
  for (std::size_t k = 0; k + 1 < layers_.size(); ++k, std::swap(here, there)) {
    layers_[k].Apply(x, here);
    Activate({here, layers_[k].outputs});
    x = here;
  }
  layers_.back().Apply(x, outputs.data());
  return std::all_of(outputs.begin(), outputs.end(), [](double y) { return std::isfinite(y); });
}

}  // namespace palpate
