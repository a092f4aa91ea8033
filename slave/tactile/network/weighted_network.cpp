// Evaluates recurrent networks, feed-forward networks and networks that use signal traces.
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "slave/tactile/network/network_weights.h"
#include "slave/tactile/network/signal_traces.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Uses exponentials, which Eigen evaluates for several numbers at once. 0 and +-1 are exact.
template <typename Derived>
auto Sigmoid(const Eigen::ArrayBase<Derived>& x) {
  return (1 + (-x).exp()).inverse();
}
template <typename Derived>
auto Tanh(const Eigen::ArrayBase<Derived>& x) {
  return 2 * (1 + (-2 * x).exp()).inverse() - 1;
}

void Activate(HiddenActivation activation, VectorXd* values) noexcept {
  auto y = values->array();
  switch (activation) {
    case HiddenActivation::kTanh:
      y = Tanh(y);
      break;
    case HiddenActivation::kRelu:
      y = y.max(0.0);
      break;
    case HiddenActivation::kSigmoid:
      y = Sigmoid(y);
      break;
    case HiddenActivation::kElu:
      y = (y > 0).select(y, y.min(0.0).exp() - 1);
      break;
    case HiddenActivation::kLeakyRelu:
      y = y.max(kLeak * y);
      break;
    case HiddenActivation::kIdentity:
      break;
  }
}

constexpr double kMinSize2 = 0.01;  // of quadratic networks [by definition]

// Returns whether this output is a coordinate of the contact point, which is no force.
bool IsPlace(const NetworkInfo& info, std::size_t output) {
  return info.gives_contact_point && output >= 3 && output < 6;
}

// The layers NetworkWeights::dense, the scaling of the outputs and the gain. Immutable.
class DenseStack {
 public:
  // Working memory for the values between the layers.
  using Scratch = std::vector<VectorXd>;

  // `weights` must be valid according to FaultOf.
  DenseStack(const NetworkWeights& weights, const NetworkInfo& info) {
    for (const DenseLayer& layer : weights.dense) {
      layers_.push_back(
          {layer.kernel.transpose().cast<double>(), layer.bias.cast<double>(), layer.activation});
    }
    VectorXd gain = VectorXd::Constant(info.outputs, info.gain);
    if (info.gives_contact_point) gain.segment(3, 3).setOnes();
    const VectorXd scale = gain.cwiseProduct(weights.output_scale.cast<double>());
    Layer& last = layers_.back();
    last.kernel = (scale.asDiagonal() * last.kernel).eval();
    last.bias =
        gain.cwiseProduct(weights.output_mean.cast<double>()) + scale.cwiseProduct(last.bias);
  }

  [[nodiscard]] Scratch MakeScratch() const {
    Scratch scratch;
    for (const Layer& layer : layers_) scratch.emplace_back(VectorXd::Zero(layer.bias.size()));
    return scratch;
  }
  // x: as many numbers as the first layer has inputs. Returns false if an output is not finite.
  // Does not allocate.
  bool Evaluate(const VectorXd& x, Scratch* scratch, std::span<double> outputs) const noexcept {
    const VectorXd* input = &x;
    for (std::size_t k = 0; k < layers_.size(); ++k) {
      VectorXd& y = (*scratch)[k];
      y = layers_[k].bias;
      y.noalias() += layers_[k].kernel * *input;
      if (k + 1 < layers_.size()) Activate(layers_[k].activation, &y);
      input = &y;
    }
    std::ranges::copy(*input, outputs.begin());
    return input->allFinite();
  }

 private:
  struct Layer {
    MatrixXd kernel;  // outputs x inputs
    VectorXd bias;
    HiddenActivation activation;
  };
  std::vector<Layer> layers_;  // the last layer returns the scaled outputs
};

// A layer of LSTM, see LstmLayer. Immutable.
class RecurrentLayer {
 public:
  struct State {
    VectorXd h, c, z;  // z: before the gates
  };

  explicit RecurrentLayer(const LstmLayer& layer)
      : units_(layer.units()),
        input_kernel_(
            layer.kernel.topRows(layer.kernel.rows() - units_).transpose().cast<double>()),
        own_kernel_(layer.kernel.bottomRows(units_).transpose().cast<double>()),
        bias_(layer.bias.cast<double>()) {
    bias_.segment(2 * units_, units_).array() += static_cast<double>(kForgetBias);
  }

  [[nodiscard]] State MakeState() const {
    return {VectorXd::Zero(units_), VectorXd::Zero(units_), VectorXd::Zero(bias_.size())};
  }
  void Step(const Eigen::Ref<const VectorXd>& x, State* s) const noexcept {
    s->z = bias_;
    s->z.noalias() += input_kernel_ * x;
    s->z.noalias() += own_kernel_ * s->h;
    const auto part = [&](Eigen::Index k) { return s->z.segment(k * units_, units_).array(); };
    s->c.array() = s->c.array() * Sigmoid(part(2)) + Sigmoid(part(0)) * Tanh(part(1));
    s->h.array() = Tanh(s->c.array()) * Sigmoid(part(3));
  }

 private:
  Eigen::Index units_;
  MatrixXd input_kernel_, own_kernel_;  // gates x inputs, gates x units
  VectorXd bias_;
};

// NetworkParts is shared by all estimates of a network.
struct NetworkParts {
  NetworkInfo info;
  VectorXd input_mean, input_scale;
  std::vector<RecurrentLayer> layers;
  DenseStack stack;
};

class WeightedEstimate final : public ForceEstimate {
 public:
  explicit WeightedEstimate(std::shared_ptr<const NetworkParts> parts)
      : parts_(std::move(parts)),
        x_(parts_->input_mean.size()),
        window_(x_.size(), parts_->layers.empty() ? 0 : parts_->info.window),
        scratch_(parts_->stack.MakeScratch()) {
    for (const RecurrentLayer& layer : parts_->layers) states_.push_back(layer.MakeState());
    if (IsTraced(parts_->info.architecture)) {
      traces_.emplace(x_.size(), parts_->info.channels.count, parts_->info.rate);
    }
    features_.resize(FeaturesOf(parts_->info));
  }

  void Reset() noexcept override {
    if (traces_) traces_->Reset();
    taken_ = 0;
  }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    const Eigen::Map<const VectorXd> signals(change.data(), x_.size());
    if (!signals.allFinite()) {
      Reset();
      return false;
    }
    x_ = (signals - parts_->input_mean).cwiseQuotient(parts_->input_scale);
    const double size = traces_ ? traces_->Take(x_, features_) : 1;
    if (window_.cols() > 0) window_.col(taken_ % window_.cols()) = x_;
    ++taken_;
    if (taken_ < parts_->info.window) return false;
    const bool is_finite = parts_->stack.Evaluate(Features(), &scratch_, outputs);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      if (!IsPlace(parts_->info, i)) outputs[i] *= size;
    }
    return is_finite;
  }

 private:
  // Input of the dense layers: the last h after the window's samples, the features, or the sample.
  const VectorXd& Features() noexcept {
    if (traces_) return features_;
    if (IsQuadratic(parts_->info.architecture)) {
      const double size = std::sqrt(x_.squaredNorm() / static_cast<double>(x_.size()) + kMinSize2);
      features_ << x_, x_ * size, x_.cwiseAbs2();
      return features_;
    }
    if (states_.empty()) return x_;
    for (RecurrentLayer::State& state : states_) {
      state.h.setZero();
      state.c.setZero();
    }
    for (Eigen::Index k = 0; k < window_.cols(); ++k) {
      parts_->layers[0].Step(window_.col((taken_ + k) % window_.cols()), &states_[0]);
      for (std::size_t i = 1; i < states_.size(); ++i) {
        parts_->layers[i].Step(states_[i - 1].h, &states_[i]);
      }
    }
    return states_.back().h;
  }

  std::shared_ptr<const NetworkParts> parts_;
  VectorXd x_;       // the scaled sample
  MatrixXd window_;  // inputs x window, a ring; recurrent networks only
  std::optional<SignalTraces> traces_;
  VectorXd features_;
  std::vector<RecurrentLayer::State> states_;  // one for each layer
  DenseStack::Scratch scratch_;
  Eigen::Index taken_ = 0;  // samples since the window began
};

class WeightedNetwork final : public ForceNetwork {
 public:
  explicit WeightedNetwork(NetworkParts parts)
      : parts_(std::make_shared<NetworkParts>(std::move(parts))) {}

  [[nodiscard]] const NetworkInfo& info() const override { return parts_->info; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    return std::make_unique<WeightedEstimate>(parts_);
  }

 private:
  std::shared_ptr<const NetworkParts> parts_;
};

}  // namespace

std::unique_ptr<ForceNetwork> MakeForceNetwork(const NetworkInfo& info,
                                               const NetworkWeights& weights) {
  const std::string fault = FaultOf(info, weights);
  if (!fault.empty()) throw std::invalid_argument(fault);
  return std::make_unique<WeightedNetwork>(NetworkParts{info,
                                                        weights.input_mean.cast<double>(),
                                                        weights.input_scale.cast<double>(),
                                                        {weights.lstm.begin(), weights.lstm.end()},
                                                        DenseStack(weights, info)});
}

}  // namespace palpate
