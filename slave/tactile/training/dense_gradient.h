// Backpropagation of the feed-forward network that the paper compares with (paper B, IV.A, after
// Su et al.).
#pragma once

#include <memory>
#include <vector>

#include "slave/tactile/training/batch_gradient.h"

namespace palpate {

// Hidden layers of tanh units, `hidden` of them in turn, and a linear output of three, of one
// sample. Weights in this order, matrices column by column: per layer W inputs x outputs, b.
std::unique_ptr<BatchGradient> MakeDenseGradient(int inputs, const std::vector<int>& hidden);

}  // namespace palpate
