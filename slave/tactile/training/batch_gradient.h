// A network for training: outputs of a batch of samples, and the gradient of the loss.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/network/network_weights.h"

namespace palpate {

// The weights of a network are one vector, so that optimisers are independent of its layers. Inputs
// and outputs are scaled to the order of 1. One thread; stores the results of Forward for Backward.
class BatchGradient {
 public:
  // `steps` matrices of batch x inputs in the order of time, the last one being the present.
  using Batch = std::span<const Eigen::MatrixXf>;

  virtual ~BatchGradient() = default;
  BatchGradient() = default;
  BatchGradient(const BatchGradient&) = delete;
  BatchGradient& operator=(const BatchGradient&) = delete;

  // Window size in samples, the present one included.
  [[nodiscard]] virtual int steps() const = 0;
  [[nodiscard]] virtual int inputs() const = 0;
  [[nodiscard]] virtual Eigen::Index weight_count() const = 0;
  // Initial weights; the same seed gives the same weights.
  [[nodiscard]] virtual Eigen::VectorXf Initial(std::uint64_t seed) const = 0;
  // batch x 3. Valid until the next call.
  virtual const Eigen::MatrixXf& Forward(const Eigen::VectorXf& weights, Batch batch) = 0;
  // Adds the gradient of the loss to `gradient`, from that with respect to the outputs (batch x 3)
  // of the last Forward.
  virtual void Backward(const Eigen::VectorXf& weights, const Eigen::MatrixXf& d_outputs,
                        Eigen::VectorXf* gradient) = 0;
  // The layers in the network's format; scales are unchanged.
  virtual void FillLayers(const Eigen::VectorXf& weights, NetworkWeights* network) const = 0;
};

// Backpropagation of the feed-forward network that the paper compares with (paper B, IV.A, after Su
// et al.). Hidden layers of tanh units, `hidden` of them in turn, and a linear output of three, of
// one sample. Weights in this order, matrices column by column: per layer W inputs x outputs, b.
std::unique_ptr<BatchGradient> MakeDenseGradient(int inputs, const std::vector<int>& hidden);

// Backpropagation through time of the paper's recurrent network (paper B, figure 6). Two LSTM
// layers of `hidden` units over `steps` samples from a state of zero, then a linear output of
// three. Per layer z = [x, h] K + b in four blocks i, j, f, o:
//
//   c' = c sigmoid(f + 1) + sigmoid(i) tanh(j),   h' = tanh(c') sigmoid(o)
//
// Weights in this order, matrices column by column: K1 (inputs + hidden) x 4 hidden, b1,
// K2 2 hidden x 4 hidden, b2, W hidden x 3, b 3.
std::unique_ptr<BatchGradient> MakeLstmGradient(int inputs, int hidden, int steps);

}  // namespace palpate
