// Forward passes of recurrent networks, feed-forward networks and networks of traces.
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "slave/tactile/network/network_weights.h"
#include "slave/tactile/network/signal_traces.h"

namespace palpate {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// By exponentials, which Eigen evaluates for several numbers at once. 0 and +-1 are exact.
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

// The layers NetworkWeights::dense, the scaling of the outputs and the gain. Immutable.
class DenseStack {
 public:
  // Room for the values between the layers.
  using Scratch = std::vector<VectorXd>;

  // `weights` without fault (FaultOf).
  DenseStack(const NetworkWeights& weights, double gain) {
    for (const DenseLayer& layer : weights.dense) {
      layers_.push_back(
          {layer.kernel.transpose().cast<double>(), layer.bias.cast<double>(), layer.activation});
    }
    const VectorXd scale = gain * weights.output_scale.cast<double>();
    Layer& last = layers_.back();
    last.kernel = (scale.asDiagonal() * last.kernel).eval();
    last.bias = gain * weights.output_mean.cast<double>() + scale.cwiseProduct(last.bias);
  }

  [[nodiscard]] Scratch MakeScratch() const {
    Scratch scratch;
    for (const Layer& layer : layers_) scratch.emplace_back(VectorXd::Zero(layer.bias.size()));
    return scratch;
  }
  // x: as many numbers as the first layer has inputs. False: an output is not finite.
  // Allocation-free.
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
  std::vector<Layer> layers_;  // the last one gives the scaled outputs
};

// The state of one recurrent layer in several lanes, which are its columns.
struct LaneStates {
  MatrixXd h, c;          // units x lanes; c: LSTM only
  MatrixXd z, recurrent;  // before the gates; recurrent: GRU only
  VectorXd shared;        // the part of z that is the same in all lanes
};

// A layer of LSTM or GRU. Immutable.
class RecurrentLayer {
 public:
  explicit RecurrentLayer(const LstmLayer& layer)
      : RecurrentLayer(layer.kernel, layer.bias, layer.units()) {
    bias_.segment(2 * units_, units_).array() += static_cast<double>(kForgetBias);
  }
  explicit RecurrentLayer(const GruLayer& layer)
      : RecurrentLayer(layer.kernel, layer.bias, layer.units()) {
    candidate_bias_ = layer.candidate_bias.cast<double>();
  }

  [[nodiscard]] Eigen::Index units() const { return units_; }
  [[nodiscard]] LaneStates MakeStates(Eigen::Index lanes) const {
    const MatrixXd zero = MatrixXd::Zero(units_, lanes),
                   gates = MatrixXd::Zero(bias_.size(), lanes);
    return {zero, zero, gates, zero, VectorXd::Zero(bias_.size())};
  }
  // All lanes process their column of `input`, or its only column. Allocation-free.
  void Step(const Eigen::Ref<const MatrixXd>& input, LaneStates* s) const noexcept {
    s->shared = bias_;
    const bool is_shared = input.cols() != s->h.cols();
    if (is_shared) s->shared.noalias() += input_kernel_ * input.col(0);
    s->z.colwise() = s->shared;
    if (!is_shared) s->z.noalias() += input_kernel_.lazyProduct(input);
    if (candidate_bias_.size() > 0) {
      StepGru(s);
    } else {
      StepLstm(s);
    }
  }

 private:
  RecurrentLayer(const WeightMatrix& kernel, const Eigen::VectorXf& bias, Eigen::Index units)
      : units_(units),
        input_kernel_(kernel.topRows(kernel.rows() - units).transpose().cast<double>()),
        own_kernel_(kernel.bottomRows(units).transpose().cast<double>()),
        bias_(bias.cast<double>()) {}

  // Rows of part `k` of the gates.
  [[nodiscard]] auto Part(MatrixXd& z, Eigen::Index k) const {
    return z.middleRows(k * units_, units_).array();
  }
  void StepLstm(LaneStates* s) const noexcept {
    s->z.noalias() += own_kernel_.lazyProduct(s->h);
    const auto i = Part(s->z, 0), j = Part(s->z, 1), f = Part(s->z, 2), o = Part(s->z, 3);
    s->c.array() = s->c.array() * Sigmoid(f) + Sigmoid(i) * Tanh(j);
    s->h.array() = Tanh(s->c.array()) * Sigmoid(o);
  }
  void StepGru(LaneStates* s) const noexcept {
    s->z.topRows(2 * units_).noalias() += own_kernel_.topRows(2 * units_).lazyProduct(s->h);
    s->recurrent.colwise() = candidate_bias_;
    s->recurrent.noalias() += own_kernel_.bottomRows(units_).lazyProduct(s->h);
    const auto r = Part(s->z, 0), z = Part(s->z, 1), n = Part(s->z, 2);
    auto candidate = s->recurrent.array();
    candidate = Tanh(n + Sigmoid(r) * candidate);
    s->h.array() = candidate + Sigmoid(z) * (s->h.array() - candidate);
  }

  Eigen::Index units_;
  MatrixXd input_kernel_, own_kernel_;  // gates x inputs, gates x units
  VectorXd bias_, candidate_bias_;      // candidate_bias_ is empty for LSTM
};

// The signals that the network takes.
bool Finite(const TactileSignals& change, Eigen::Index inputs) noexcept {
  return std::all_of(change.begin(), change.begin() + inputs,
                     [](auto x) { return std::isfinite(x); });
}

struct InputScaling {
  explicit InputScaling(const NetworkWeights& weights)
      : mean(weights.input_mean.cast<double>()), scale(weights.input_scale.cast<double>()) {}
  void Apply(const TactileSignals& change, VectorXd* x) const noexcept {
    const Eigen::Map<const VectorXd> signals(change.data(), x->size());
    *x = (signals - mean).cwiseQuotient(scale);
  }
  VectorXd mean, scale;
};

// What an estimate shares with the network it comes from.
struct RecurrentParts {
  int window;
  InputScaling input;
  std::vector<RecurrentLayer> layers;
  DenseStack head;
};

// A lane for each window that contains a sample, restarted when its window is over.
class RecurrentEstimate final : public ForceEstimate {
 public:
  explicit RecurrentEstimate(std::shared_ptr<const RecurrentParts> parts)
      : parts_(std::move(parts)),
        x_(parts_->input.mean.size()),
        h_(parts_->layers.back().units()),
        scratch_(parts_->head.MakeScratch()) {
    for (const RecurrentLayer& layer : parts_->layers) {
      states_.push_back(layer.MakeStates(parts_->window));
    }
  }

  void Reset() noexcept override {
    for (LaneStates& state : states_) {
      state.h.setZero();
      state.c.setZero();
    }
    seen_ = 0;
    oldest_ = 0;
  }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    if (!Finite(change, x_.size())) {
      Reset();
      return false;
    }
    parts_->input.Apply(change, &x_);
    for (std::size_t k = 0; k < states_.size(); ++k) {
      states_[k].h.col(oldest_).setZero();
      states_[k].c.col(oldest_).setZero();
      if (k == 0) {
        parts_->layers[k].Step(x_, &states_[k]);
      } else {
        parts_->layers[k].Step(states_[k - 1].h, &states_[k]);
      }
    }
    oldest_ = (oldest_ + 1) % parts_->window;
    seen_ = std::min(seen_ + 1, parts_->window);
    if (seen_ < parts_->window) return false;
    h_ = states_.back().h.col(oldest_);
    return parts_->head.Evaluate(h_, &scratch_, outputs);
  }

 private:
  std::shared_ptr<const RecurrentParts> parts_;
  std::vector<LaneStates> states_;  // one for each layer
  VectorXd x_, h_;
  DenseStack::Scratch scratch_;
  int seen_ = 0;    // at most a window
  int oldest_ = 0;  // the lane that began first, which restarts next
};

struct FeedForwardParts {
  InputScaling input;
  DenseStack stack;
};

// Without memory: every sample is a window.
class FeedForwardEstimate final : public ForceEstimate {
 public:
  explicit FeedForwardEstimate(std::shared_ptr<const FeedForwardParts> parts)
      : parts_(std::move(parts)),
        x_(parts_->input.mean.size()),
        scratch_(parts_->stack.MakeScratch()) {}

  void Reset() noexcept override {}
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    if (!Finite(change, x_.size())) return false;
    parts_->input.Apply(change, &x_);
    return parts_->stack.Evaluate(x_, &scratch_, outputs);
  }

 private:
  std::shared_ptr<const FeedForwardParts> parts_;
  VectorXd x_;
  DenseStack::Scratch scratch_;
};

struct TracedParts {
  int window;
  Eigen::VectorXf scale;
  double rate;
  DenseStack stack;
};

// Carries its traces on from where the window began; the window is what they need to settle.
class TracedEstimate final : public ForceEstimate {
 public:
  explicit TracedEstimate(std::shared_ptr<const TracedParts> parts)
      : parts_(std::move(parts)),
        traces_(parts_->scale.size(), parts_->rate),
        now_(parts_->scale.size()),
        features_(FeatureCount(parts_->scale.size())),
        x_(features_.size()),
        scratch_(parts_->stack.MakeScratch()) {}

  void Reset() noexcept override {
    traces_.Reset();
    seen_ = 0;
  }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    if (!Finite(change, now_.size())) {
      Reset();
      return false;
    }
    const Eigen::Map<const VectorXd> signals(change.data(), now_.size());
    now_ = signals.cast<float>().cwiseQuotient(parts_->scale);
    const auto size = static_cast<double>(traces_.Take(now_, features_));
    seen_ = std::min(seen_ + 1, parts_->window);
    if (seen_ < parts_->window) return false;
    x_ = features_.cast<double>();
    const bool is_finite = parts_->stack.Evaluate(x_, &scratch_, outputs);
    for (double& output : outputs) output *= size;
    return is_finite;
  }

 private:
  std::shared_ptr<const TracedParts> parts_;
  SignalTraces traces_;
  Eigen::VectorXf now_, features_;
  VectorXd x_;
  DenseStack::Scratch scratch_;
  int seen_ = 0;  // at most a window
};

// `Parts`: what the network shares with its estimates.
template <class Estimate, class Parts>
class WeightedNetwork final : public ForceNetwork {
 public:
  WeightedNetwork(const NetworkInfo& info, Parts parts)
      : info_(info), parts_(std::make_shared<Parts>(std::move(parts))) {}

  [[nodiscard]] const NetworkInfo& info() const override { return info_; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    return std::make_unique<Estimate>(parts_);
  }

 private:
  NetworkInfo info_;
  std::shared_ptr<const Parts> parts_;
};

}  // namespace

std::unique_ptr<ForceNetwork> MakeForceNetwork(const NetworkInfo& info,
                                               const NetworkWeights& weights) {
  const std::string fault = FaultOf(info, weights);
  if (!fault.empty()) throw std::invalid_argument(fault);
  const NetworkWeights& w = weights;
  DenseStack stack(w, info.gain);
  if (IsRecurrent(info.architecture)) {
    std::vector<RecurrentLayer> layers;
    for (const LstmLayer& layer : w.lstm) layers.emplace_back(layer);
    for (const GruLayer& layer : w.gru) layers.emplace_back(layer);
    return std::make_unique<WeightedNetwork<RecurrentEstimate, RecurrentParts>>(
        info, RecurrentParts{info.window, InputScaling(w), std::move(layers), std::move(stack)});
  }
  if (IsTraced(info.architecture)) {
    return std::make_unique<WeightedNetwork<TracedEstimate, TracedParts>>(
        info, TracedParts{info.window, w.input_scale, info.rate, std::move(stack)});
  }
  return std::make_unique<WeightedNetwork<FeedForwardEstimate, FeedForwardParts>>(
      info, FeedForwardParts{InputScaling(w), std::move(stack)});
}

}  // namespace palpate
