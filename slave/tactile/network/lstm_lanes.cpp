#include "slave/tactile/network/lstm_lanes.h"

#include <utility>

namespace palpate {

LstmLanes::LstmLanes(std::shared_ptr<const LstmPlan> plan, int lanes) : plan_(std::move(plan)) {
  const long width = plan_->kernel().width;
  stride_ = (lanes + width - 1) / width * width;
  projected_ = CacheLines(4 * static_cast<std::size_t>(plan_->layers().front().units));
  for (const auto& layer : plan_->layers()) {
    const auto count = static_cast<std::size_t>(layer.units) * static_cast<std::size_t>(stride_);
    states_.push_back({CacheLines(count), CacheLines(count), CacheLines(count)});
  }
}

void LstmLanes::Restart() noexcept {
  for (State& state : states_) {
    state.own.Clear();
    state.cell.Clear();
  }
}

void LstmLanes::Restart(int lane) noexcept {
  for (std::size_t k = 0; k < states_.size(); ++k) {
    for (int unit = 0; unit < plan_->layers()[k].units; ++unit) {
      const auto place = static_cast<std::size_t>(unit * stride_ + lane);
      states_[k].own[place] = 0;
      states_[k].cell[place] = 0;
    }
  }
}

void LstmLanes::Step(const TactileSignals& change) noexcept {
  plan_->Project(change, projected_.data());
  for (std::size_t k = 0; k < states_.size(); ++k) {
    const LstmPlan::Layer& layer = plan_->layers()[k];
    State& state = states_[k];
    plan_->kernel().step(
        {.units = layer.units,
         .lanes = stride_,
         .stride = stride_,
         .base = k == 0 ? projected_.data() : layer.base.data(),
         .weights = layer.weights.data(),
         .below_rows = layer.below_rows,
         .below = states_[k == 0 ? 0 : k - 1].own.data(),  // no rows of it for the first
         .own = state.own.data(),
         .next = state.next.data(),
         .cell = state.cell.data()});
    std::swap(state.own, state.next);
  }
}

void LstmLanes::Output(int lane, double* h) const noexcept {
  const double* own = states_.back().own.data();
  for (int unit = 0; unit < plan_->layers().back().units; ++unit) {
    h[unit] = own[unit * stride_ + lane];
  }
}

}  // namespace palpate
