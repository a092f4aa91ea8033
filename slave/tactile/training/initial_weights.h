// Where learning starts.
#pragma once

#include <cmath>
#include <random>

#include <Eigen/Core>

namespace palpate {

// Fills a matrix of `inputs` x `outputs` at `weights` with numbers drawn uniformly from
// +-sqrt(6 / (inputs + outputs)), which keeps signals and gradients at their size from layer to
// layer (Glorot and Bengio 2010). Drawn from the generator's bits, so that every library gives the
// same numbers.
inline void SpreadUniformly(Eigen::Index inputs, Eigen::Index outputs, std::mt19937_64* random,
                            float* weights) {
  const double bound = std::sqrt(6.0 / static_cast<double>(inputs + outputs));
  for (Eigen::Index i = 0; i < inputs * outputs; ++i) {
    const double unit = static_cast<double>((*random)() >> 11) * 0x1p-53;  // 0 to 1
    weights[i] = static_cast<float>(bound * (2 * unit - 1));
  }
}

}  // namespace palpate
