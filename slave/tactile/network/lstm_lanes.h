// LSTM layers arranged for the kernel, and copies of them that advance together.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "slave/tactile/network/lstm_kernel.h"
#include "slave/tactile/network/network_weights.h"

namespace palpate {

// Doubles that begin at a multiple of 64 bytes, as wide registers like them.
class CacheLines {
 public:
  CacheLines() = default;
  // Zeros.
  explicit CacheLines(std::size_t count) : lines_((count + kPerLine - 1) / kPerLine) {}

  [[nodiscard]] double* data() noexcept { return lines_.empty() ? nullptr : lines_[0].numbers; }
  [[nodiscard]] const double* data() const noexcept {
    return lines_.empty() ? nullptr : lines_[0].numbers;
  }
  double& operator[](std::size_t i) noexcept { return data()[i]; }
  void Clear() noexcept { lines_.assign(lines_.size(), Line{}); }

 private:
  static constexpr std::size_t kPerLine = 8;
  struct alignas(64) Line {
    double numbers[kPerLine] = {};
  };
  std::vector<Line> lines_;
};

// LSTM layers arranged for the kernel. Immutable.
class LstmPlan {
 public:
  struct Layer {
    int units = 0;
    int below_rows = 0;  // 0 for the first: its inputs are the same in all lanes
    CacheLines weights;  // LstmStep::weights
    CacheLines base;     // 4 units: the biases
  };

  // `weights` without fault (FaultOf), with lstm layers. Input scaling is folded in.
  LstmPlan(const NetworkWeights& weights, const LstmKernel& kernel);

  [[nodiscard]] const LstmKernel& kernel() const { return kernel_; }
  [[nodiscard]] const std::vector<Layer>& layers() const { return layers_; }
  [[nodiscard]] int inputs() const { return static_cast<int>(mean_.size()); }

  // The part that the first layer's lanes share for the sample `change` (inputs() counts minus
  // baseline): `base`, 4 units. Real-time safe.
  void Project(const TactileSignals& change, double* base) const noexcept;

 private:
  LstmKernel kernel_;
  std::vector<Layer> layers_;
  std::vector<double> mean_;
  std::vector<double> projection_;  // inputs x 4 units of the first layer
};

// Copies of a recurrent network for the same samples that differ in their start: one for each
// window that contains a sample. All of them advance together, and each sample passes the input
// weights once. Real-time safe once constructed.
class LstmLanes {
 public:
  LstmLanes(std::shared_ptr<const LstmPlan> plan, int lanes);

  // The state of zero, for all lanes or for one.
  void Restart() noexcept;
  void Restart(int lane) noexcept;
  // All lanes process the next sample: counts minus baseline, finite inputs of the network.
  void Step(const TactileSignals& change) noexcept;
  // The last layer's h of a lane, one number per unit.
  void Output(int lane, double* h) const noexcept;

 private:
  struct State {
    CacheLines own, next, cell;  // units x stride
  };

  std::shared_ptr<const LstmPlan> plan_;
  long stride_;
  CacheLines projected_;
  std::vector<State> states_;  // one per layer
};

}  // namespace palpate
