// LSTM layers arranged for the kernel.
#pragma once

#include <vector>

#include "slave/tactile/network/cache_lines.h"
#include "slave/tactile/network/lstm_kernel.h"
#include "slave/tactile/network/network_weights.h"

namespace palpate {

// Immutable.
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

  // What the first layer's lanes have in common when they take the sample `change` (inputs() counts
  // minus rest): `base`, 4 units. Real-time safe.
  void Project(const TactileSignals& change, double* base) const noexcept;

 private:
  LstmKernel kernel_;
  std::vector<Layer> layers_;
  std::vector<double> mean_;
  std::vector<double> projection_;  // inputs x 4 units of the first layer
};

}  // namespace palpate
