// The inner loop of LSTM layers: one step of many independent copies of a layer (lanes), stored
// side by side so that each instruction serves several of them.
#pragma once

#include <span>

namespace palpate {

// One step of one layer. Arrays `rows x stride` have one row per unit and one column per lane; rows
// begin at multiples of the kernel's width.
struct LstmStep {
  long units = 0;
  long lanes = 0;                   // a multiple of the kernel's width
  long stride = 0;                  // >= lanes, a multiple of the kernel's width
  const double* base = nullptr;     // 4 units, unit by unit i j f o: the part that all lanes share
  const double* weights = nullptr;  // units x (below_rows + units) x 4 gates
  long below_rows = 0;
  const double* below = nullptr;  // below_rows x stride: present output of the layer below
  const double* own = nullptr;    // units x stride: h before the step
  double* next = nullptr;         // units x stride: output h of this step; not `own`
  double* cell = nullptr;         // units x stride: c, updated in place
};

// Weights and base are scaled so that the exponentials are powers of two: gates i, f, o by
// -log2(e), j by -2 log2(e); the forget bias is in the base. Powers are good to
// 2e-10; beyond 2^60 and 2^-60 they change nothing and are clamped.
struct LstmKernel {
  const char* name;    // of its instructions
  long width;          // lanes per instruction
  long weight_copies;  // number of copies of each weight in LstmStep::weights, side by side
  void (*step)(const LstmStep&) noexcept;
};

// Those that this machine can run, the fastest first; never empty.
std::span<const LstmKernel> LstmKernels() noexcept;

}  // namespace palpate
