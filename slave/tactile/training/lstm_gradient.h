// Backpropagation through time of the paper's recurrent network (paper B, figure 6).
#pragma once

#include <memory>

#include "slave/tactile/training/batch_gradient.h"

namespace palpate {

// Two LSTM layers of `hidden` units over `steps` samples from a state of zero, then a linear output
// of three. Per layer z = [x, h] K + b in four blocks i, j, f, o:
//
//   c' = c sigmoid(f + 1) + sigmoid(i) tanh(j),   h' = tanh(c') sigmoid(o)
//
// Weights in this order, matrices column by column: K1 (inputs + hidden) x 4 hidden, b1,
// K2 2 hidden x 4 hidden, b2, W hidden x 3, b 3.
std::unique_ptr<BatchGradient> MakeLstmGradient(int inputs, int hidden, int steps);

}  // namespace palpate
