// Networks given by their weights: recurrent and feed-forward ones.
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>
#include <vector>

#include "slave/tactile/network/dense_stack.h"
#include "slave/tactile/network/lstm_lanes.h"
#include "slave/tactile/network/network_weights.h"

namespace palpate {
namespace {

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

// Windowed: a lane for each window that a sample belongs to, begun anew when its window is over.
// Carrying the state on: a single lane that is never begun anew.
class LstmEstimate final : public ForceEstimate {
 public:
  LstmEstimate(std::shared_ptr<const RecurrentParts> parts, bool windowed)
      : parts_(std::move(parts)),
        windowed_(windowed),
        lane_count_(windowed ? parts_->window : 1),
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
    if (windowed_) lanes_.Restart(oldest_);
    lanes_.Step(change);
    oldest_ = (oldest_ + 1) % lane_count_;
    seen_ = std::min(seen_ + 1, parts_->window);
    if (seen_ < parts_->window) return false;
    lanes_.Output(oldest_, h_.data());
    return parts_->head.Evaluate(h_.data(), scratch_, outputs);
  }

 private:
  std::shared_ptr<const RecurrentParts> parts_;
  bool windowed_;
  int lane_count_;
  LstmLanes lanes_;
  std::vector<double> h_, scratch_;
  int seen_ = 0;    // at most a window
  int oldest_ = 0;  // the lane that began first: the next to begin anew
};

class RecurrentNetwork final : public ForceNetwork {
 public:
  RecurrentNetwork(const NetworkInfo& info, const NetworkWeights& weights)
      : info_(info),
        parts_(std::make_shared<RecurrentParts>(
            RecurrentParts{info.window, std::make_shared<LstmPlan>(weights, LstmKernels().front()),
                           DenseStack(weights, info.gain)})) {}

  [[nodiscard]] const NetworkInfo& info() const override { return info_; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    return std::make_unique<LstmEstimate>(parts_, true);
  }
  [[nodiscard]] bool HasState() const override { return true; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> CarryingState() const override {
    return std::make_unique<LstmEstimate>(parts_, false);
  }

 private:
  NetworkInfo info_;
  std::shared_ptr<const RecurrentParts> parts_;
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

class FeedForwardNetwork final : public ForceNetwork {
 public:
  FeedForwardNetwork(const NetworkInfo& info, const NetworkWeights& weights)
      : info_(info),
        parts_(std::make_shared<FeedForwardParts>(
            FeedForwardParts{{weights.input_mean.begin(), weights.input_mean.end()},
                             {weights.input_scale.begin(), weights.input_scale.end()},
                             DenseStack(weights, info.gain)})) {}

  [[nodiscard]] const NetworkInfo& info() const override { return info_; }
  [[nodiscard]] std::unique_ptr<ForceEstimate> Windowed() const override {
    return std::make_unique<FeedForwardEstimate>(parts_);
  }
  [[nodiscard]] std::unique_ptr<ForceEstimate> CarryingState() const override { return Windowed(); }

 private:
  NetworkInfo info_;
  std::shared_ptr<const FeedForwardParts> parts_;
};

}  // namespace

std::unique_ptr<ForceNetwork> MakeForceNetwork(const NetworkInfo& info,
                                               const NetworkWeights& weights) {
  const std::string fault = FaultOf(info, weights);
  if (!fault.empty()) throw std::invalid_argument(fault);
  if (IsRecurrent(info.architecture)) return std::make_unique<RecurrentNetwork>(info, weights);
  return std::make_unique<FeedForwardNetwork>(info, weights);
}

}  // namespace palpate
