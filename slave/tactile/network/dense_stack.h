// The feed-forward part of a network.
#pragma once

#include <span>
#include <vector>

#include "slave/tactile/network/network_weights.h"

namespace palpate {

// The layers NetworkWeights::dense, the scaling of the outputs and the gain. Immutable.
class DenseStack {
 public:
  // `weights` without fault (FaultOf).
  DenseStack(const NetworkWeights& weights, double gain);

  // How many numbers Evaluate needs as `scratch`.
  [[nodiscard]] std::size_t scratch_size() const { return 2 * widest_; }
  // x: as many numbers as the first layer has inputs. False: an output is not finite. Real-time
  // safe.
  bool Evaluate(const double* x, std::span<double> scratch,
                std::span<double> outputs) const noexcept;

 private:
  struct Layer {
    std::size_t inputs = 0, outputs = 0;
    std::vector<double> kernel;  // inputs x outputs
    std::vector<double> bias;
    void Apply(const double* x, double* y) const noexcept;
  };
  void Activate(std::span<double> y) const noexcept;

  std::vector<Layer> layers_;  // the last one gives the scaled outputs
  HiddenActivation activation_;
  std::size_t widest_ = 0;
};

}  // namespace palpate
