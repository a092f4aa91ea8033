// The numbers a force network consists of.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/network/force_network.h"

namespace palpate {

using WeightMatrix = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// A layer of long short-term memory with n units. With z = [x, h] kernel + bias cut into four parts
// i, j, f, o of n columns each, one step is
//
//   c' = c sigmoid(f + 1) + sigmoid(i) tanh(j),   h' = tanh(c') sigmoid(o)
//
// The 1 is kForgetBias; `bias` does not contain it.
struct LstmLayer {
  WeightMatrix kernel;   // (inputs + n) x 4 n: rows the inputs, then the units
  Eigen::VectorXf bias;  // 4 n
  [[nodiscard]] Eigen::Index units() const { return kernel.cols() / 4; }
};
inline constexpr float kForgetBias = 1;

enum class HiddenActivation { kTanh, kRelu, kSigmoid, kElu, kLeakyRelu, kIdentity };
inline constexpr double kLeak = 0.01;  // slope of kLeakyRelu below 0

// activation(x kernel + bias); the last layer of a network has no activation.
struct DenseLayer {
  WeightMatrix kernel;   // inputs x outputs
  Eigen::VectorXf bias;  // outputs
  HiddenActivation activation = HiddenActivation::kTanh;
};

// x = (change - input_mean) / input_scale is the input of the first layer of `lstm`. Each layer
// passes its whole sequence to the next; the last state of the last layer is the input of `dense`.
// The outputs are NetworkInfo::gain (output_mean + output_scale y), entry by entry. Without
// recurrent layers the network is feed-forward and sees one sample.
//
// The first layer of qnn_* takes 3 N features: x, x s and the squares of x, with s = sqrt(mean x² +
// 0.01); input_mean is 0.
//
// The first layer of tnn_* takes the features of SignalTraces for `input_scale`, and the outputs
// are multiplied by the size to which the features are relative; input_mean and output_mean are 0.
struct NetworkWeights {
  Eigen::VectorXf input_mean, input_scale;  // NetworkInfo::inputs [counts]; scale not 0
  std::vector<LstmLayer> lstm;              // rnn_*: one or more
  std::vector<DenseLayer> dense;            // at least one, the last one's columns are the outputs
  Eigen::VectorXf output_mean, output_scale;  // NetworkInfo::outputs [N]

  // 0 and 1: for networks that map counts to newtons.
  void LeaveUnscaled(int inputs, int outputs);
};

// Returns the error with tensor, value and expected values; empty: none.
std::string FaultOf(const NetworkInfo& info, const NetworkWeights& weights);

// N of rnn_N, dnn_N, tnn_N or (not of electrodes) qnn_N, 1 to kMaxChannels, for electrodes 21 or
// 19; 0: another name.
int InputsOf(std::string_view architecture, bool are_electrodes);
bool IsRecurrent(std::string_view architecture);
bool IsTraced(std::string_view architecture);
bool IsQuadratic(std::string_view architecture);
// Inputs of the first dense layer of a network without recurrent layers.
Eigen::Index FeaturesOf(const NetworkInfo& info);
inline constexpr std::string_view kArchitectures = "rnn_21, rnn_19, dnn_21, dnn_19, tnn_21, tnn_19";

// Evaluates the weights. Throws std::invalid_argument: FaultOf.
std::unique_ptr<ForceNetwork> MakeForceNetwork(const NetworkInfo& info,
                                               const NetworkWeights& weights);

}  // namespace palpate
