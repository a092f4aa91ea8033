// Networks given by their weights: recurrent and feed-forward ones.
#include <algorithm>
#include <cassert>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include "slave/tactile/network/lstm_lanes.h"
#include "slave/tactile/network/network_weights.h"
#include "slave/tactile/network/signal_traces.h"

namespace palpate {
namespace {

// The feed-forward part of a network: the layers NetworkWeights::dense, the scaling of the outputs
// and the gain. Immutable.
class DenseStack {
 public:
  // `weights` without fault (FaultOf).
  DenseStack(const NetworkWeights& weights, double gain) : activation_(weights.activation) {
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

  // How many numbers Evaluate needs as `scratch`.
  [[nodiscard]] std::size_t scratch_size() const { return 2 * widest_; }
  // x: as many numbers as the first layer has inputs. False: an output is not finite. Real-time
  // safe.
  bool Evaluate(const double* x, std::span<double> scratch,
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

 private:
  struct Layer {
    std::size_t inputs = 0, outputs = 0;
    std::vector<double> kernel;  // inputs x outputs
    std::vector<double> bias;
    void Apply(const double* x, double* y) const noexcept {
      std::copy(bias.begin(), bias.end(), y);
      const double* row = kernel.data();
      for (std::size_t i = 0; i < inputs; ++i, row += outputs) {
        for (std::size_t j = 0; j < outputs; ++j) y[j] += x[i] * row[j];
      }
    }
  };
  void Activate(std::span<double> y) const noexcept {
    for (double& value : y) {
      value = activation_ == HiddenActivation::kTanh ? std::tanh(value) : std::max(value, 0.0);
    }
  }

  std::vector<Layer> layers_;  // the last one gives the scaled outputs
  HiddenActivation activation_;
  std::size_t widest_ = 0;
};

// The signals that the network takes.
bool Finite(const TactileSignals& change, int inputs) noexcept {
  return std::all_of(change.begin(), change.begin() + inputs,
                     [](auto x) { return std::isfinite(x); });
}

// What an estimate shares with the network it comes from.
struct RecurrentParts {
  int window;
  std::shared_ptr<const LstmPlan> plan;
  DenseStack head;
};

// A lane for each window that a sample belongs to, restarted when its window is over.
class LstmEstimate final : public ForceEstimate {
 public:
  explicit LstmEstimate(std::shared_ptr<const RecurrentParts> parts)
      : parts_(std::move(parts)),
        lane_count_(parts_->window),
        lanes_(parts_->plan, lane_count_),
        h_(static_cast<std::size_t>(parts_->plan->layers().back().units)),
        scratch_(parts_->head.scratch_size()) {}

  void Reset() noexcept override {
    lanes_.Restart();
    seen_ = 0;
    oldest_ = 0;
  }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    if (!Finite(change, parts_->plan->inputs())) {
      Reset();
      return false;
    }
    lanes_.Restart(oldest_);
    lanes_.Step(change);
    oldest_ = (oldest_ + 1) % lane_count_;
    seen_ = std::min(seen_ + 1, parts_->window);
    if (seen_ < parts_->window) return false;
    lanes_.Output(oldest_, h_.data());
    return parts_->head.Evaluate(h_.data(), scratch_, outputs);
  }

 private:
  std::shared_ptr<const RecurrentParts> parts_;
  int lane_count_;
  LstmLanes lanes_;
  std::vector<double> h_, scratch_;
  int seen_ = 0;    // at most a window
  int oldest_ = 0;  // the lane that began first, which restarts next
};

struct FeedForwardParts {
  std::vector<double> mean, scale;  // of the inputs
  DenseStack stack;
};

// Without memory: every sample is a window.
class FeedForwardEstimate final : public ForceEstimate {
 public:
  explicit FeedForwardEstimate(std::shared_ptr<const FeedForwardParts> parts)
      : parts_(std::move(parts)), x_(parts_->mean.size()), scratch_(parts_->stack.scratch_size()) {}

  void Reset() noexcept override {}
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    if (!Finite(change, static_cast<int>(x_.size()))) return false;
    for (std::size_t i = 0; i < x_.size(); ++i) {
      x_[i] = (static_cast<double>(change[i]) - parts_->mean[i]) / parts_->scale[i];
    }
    return parts_->stack.Evaluate(x_.data(), scratch_, outputs);
  }

 private:
  std::shared_ptr<const FeedForwardParts> parts_;
  std::vector<double> x_, scratch_;
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
        x_(static_cast<std::size_t>(features_.size())),
        scratch_(parts_->stack.scratch_size()) {}

  void Reset() noexcept override {
    traces_.Reset();
    seen_ = 0;
  }
  bool Push(const TactileSignals& change, std::span<double> outputs) noexcept override {
    if (!Finite(change, static_cast<int>(parts_->scale.size()))) {
      Reset();
      return false;
    }
    for (Eigen::Index i = 0; i < now_.size(); ++i) {
      now_[i] = static_cast<float>(change[static_cast<std::size_t>(i)]) / parts_->scale[i];
    }
    const auto size = static_cast<double>(traces_.Take(now_, features_));
    seen_ = std::min(seen_ + 1, parts_->window);
    if (seen_ < parts_->window) return false;
    std::ranges::copy(features_, x_.begin());
    const bool is_finite = parts_->stack.Evaluate(x_.data(), scratch_, outputs);
    for (double& output : outputs) output *= size;
    return is_finite;
  }

 private:
  std::shared_ptr<const TracedParts> parts_;
  SignalTraces traces_;
  Eigen::VectorXf now_, features_;
  std::vector<double> x_, scratch_;
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
    return std::make_unique<WeightedNetwork<LstmEstimate, RecurrentParts>>(
        info, RecurrentParts{info.window, std::make_shared<LstmPlan>(w, LstmKernels().front()),
                             std::move(stack)});
  }
  if (IsTraced(info.architecture)) {
    return std::make_unique<WeightedNetwork<TracedEstimate, TracedParts>>(
        info, TracedParts{info.window, w.input_scale, info.rate, std::move(stack)});
  }
  return std::make_unique<WeightedNetwork<FeedForwardEstimate, FeedForwardParts>>(
      info, FeedForwardParts{{w.input_mean.begin(), w.input_mean.end()},
                             {w.input_scale.begin(), w.input_scale.end()},
                             std::move(stack)});
}

}  // namespace palpate
