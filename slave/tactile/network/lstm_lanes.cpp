#include "slave/tactile/network/lstm_lanes.h"

#include <array>
#include <numbers>
#include <utility>

namespace palpate {

extern const LstmKernel kLstmKernelBaseline;
#ifdef PALPATE_X86_KERNELS
extern const LstmKernel kLstmKernelAvx2;
extern const LstmKernel kLstmKernelAvx512;
#endif

namespace {

struct Runnable {
  std::array<LstmKernel, 3> kernels{};
  std::size_t count = 0;

  Runnable() noexcept {
#ifdef PALPATE_X86_KERNELS
    const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
    if (avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) {
      kernels[count++] = kLstmKernelAvx512;
    }
    if (avx2) kernels[count++] = kLstmKernelAvx2;
#endif
    kernels[count++] = kLstmKernelBaseline;
  }
};

// The kernel takes powers of two: sigmoid(z) = 1 / (1 + 2^(-z log2 e)), and tanh twice that.
double GateScale(Eigen::Index gate) {
  return gate == 1 ? -2 * std::numbers::log2e : -std::numbers::log2e;
}

// The kernel's order within a layer: units, and for each its gates i, j, f, o.
std::size_t Place(Eigen::Index unit, Eigen::Index gate) {
  return static_cast<std::size_t>(4 * unit + gate);
}

double BiasOf(const LstmLayer& layer, Eigen::Index unit, Eigen::Index gate) {
  const double forget = gate == 2 ? static_cast<double>(kForgetBias) : 0;
  return static_cast<double>(layer.bias[gate * layer.units() + unit]) + forget;
}

// Rows of the kernel matrix from `first` on, unit by unit.
CacheLines Arrange(const LstmLayer& layer, Eigen::Index first, long copies) {
  const Eigen::Index units = layer.units(), rows = layer.kernel.rows() - first;
  CacheLines arranged(static_cast<std::size_t>(units * rows * 4 * copies));
  std::size_t k = 0;
  for (Eigen::Index unit = 0; unit < units; ++unit) {
    for (Eigen::Index row = first; row < layer.kernel.rows(); ++row) {
      for (Eigen::Index gate = 0; gate < 4; ++gate) {
        const auto weight = static_cast<double>(layer.kernel(row, gate * units + unit));
        for (long copy = 0; copy < copies; ++copy) arranged[k++] = GateScale(gate) * weight;
      }
    }
  }
  return arranged;
}

CacheLines ArrangeBias(const LstmLayer& layer) {
  CacheLines base(static_cast<std::size_t>(4 * layer.units()));
  for (Eigen::Index unit = 0; unit < layer.units(); ++unit) {
    for (Eigen::Index gate = 0; gate < 4; ++gate) {
      base[Place(unit, gate)] = GateScale(gate) * BiasOf(layer, unit, gate);
    }
  }
  return base;
}

}  // namespace

std::span<const LstmKernel> LstmKernels() noexcept {
  static const Runnable runnable;
  return {runnable.kernels.data(), runnable.count};
}

LstmPlan::LstmPlan(const NetworkWeights& weights, const LstmKernel& kernel) : kernel_(kernel) {
  const LstmLayer& first = weights.lstm.front();
  const Eigen::Index inputs = weights.input_mean.size(), units = first.units();
  projection_.resize(static_cast<std::size_t>(inputs * 4 * units));
  for (Eigen::Index i = 0; i < inputs; ++i) {
    mean_.push_back(static_cast<double>(weights.input_mean[i]));
    const auto scale = static_cast<double>(weights.input_scale[i]);
    for (Eigen::Index unit = 0; unit < units; ++unit) {
      for (Eigen::Index gate = 0; gate < 4; ++gate) {
        projection_[static_cast<std::size_t>(i * 4 * units) + Place(unit, gate)] =
            GateScale(gate) * static_cast<double>(first.kernel(i, gate * units + unit)) / scale;
      }
    }
  }
  for (const LstmLayer& layer : weights.lstm) {
    const bool lowest = layers_.empty();
    const int below = lowest ? 0 : layers_.back().units;
    layers_.push_back({static_cast<int>(layer.units()), below,
                       Arrange(layer, lowest ? inputs : 0, kernel.weight_copies),
                       ArrangeBias(layer)});
  }
}

void LstmPlan::Project(const TactileSignals& change, double* base) const noexcept {
  const auto gates = 4 * static_cast<std::size_t>(layers_.front().units);
  const double* bias = layers_.front().base.data();
  for (std::size_t g = 0; g < gates; ++g) base[g] = bias[g];
  const double* row = projection_.data();
  for (std::size_t i = 0; i < mean_.size(); ++i, row += gates) {
    const double x = static_cast<double>(change[i]) - mean_[i];
    for (std::size_t g = 0; g < gates; ++g) base[g] += x * row[g];
  }
}

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
