// A network as training sees it: what a batch of samples gives, and how the loss changes with every
// weight.
#pragma once

#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "slave/tactile/network/network_weights.h"

namespace palpate {

// The weights of a network are one vector, so that optimisers need not know its layers. Inputs and
// outputs are scaled: of the order of 1. One thread; keeps what Forward computed for Backward.
class BatchGradient {
 public:
  // `steps` matrices of batch x inputs in the order of time, the last one being the present.
  using Batch = std::span<const Eigen::MatrixXf>;

  virtual ~BatchGradient() = default;
  BatchGradient() = default;
  BatchGradient(const BatchGradient&) = delete;
  BatchGradient& operator=(const BatchGradient&) = delete;

  // Samples that the network looks back over, the present one included.
  [[nodiscard]] virtual int steps() const = 0;
  [[nodiscard]] virtual int inputs() const = 0;
  [[nodiscard]] virtual Eigen::Index weight_count() const = 0;
  // Where learning starts; the same seed gives the same weights.
  [[nodiscard]] virtual Eigen::VectorXf Initial(std::uint64_t seed) const = 0;
  // batch x 3. Valid until the next call.
  virtual const Eigen::MatrixXf& Forward(const Eigen::VectorXf& weights, Batch batch) = 0;
  // Adds the gradient of the loss to `gradient`, from that with respect to the outputs (batch x 3)
  // of the last Forward.
  virtual void Backward(const Eigen::VectorXf& weights, const Eigen::MatrixXf& d_outputs,
                        Eigen::VectorXf* gradient) = 0;
  // The layers as a network takes them; scales are left alone.
  virtual void FillLayers(const Eigen::VectorXf& weights, NetworkWeights* network) const = 0;
};

}  // namespace palpate
