// The LSTM kernel, compiled once per instruction set: PALPATE_LANE_BYTES is the size of a register,
// PALPATE_LANE_BLOCK how many registers of lanes go through a unit together, PALPATE_WEIGHT_COPIES
// LstmKernel::weight_copies. Nothing here may be shared between the sets: whatever the linker
// merged could hold instructions that a machine lacks.
#include "slave/tactile/network/lstm_kernel.h"

namespace palpate {
namespace {

using Lane = double __attribute__((vector_size(PALPATE_LANE_BYTES), may_alias));
using LaneBits = long long __attribute__((vector_size(PALPATE_LANE_BYTES), may_alias));

constexpr long kWidth = PALPATE_LANE_BYTES / static_cast<long>(sizeof(double));
constexpr long kWeightCopies = PALPATE_WEIGHT_COPIES;
constexpr double kLog2E = 1.4426950408889634;

[[gnu::always_inline]] inline Lane& At(double* p) {
  return *reinterpret_cast<Lane*>(p);
}
[[gnu::always_inline]] inline const Lane& At(const double* p) {
  return *reinterpret_cast<const Lane*>(p);
}

// 2^x for |x| <= 60, clamped beyond; relative error below 2e-10. x = n + r with |r| <= 1/2, and
// 2^r = (2^s)^4 with s = r / 4: 2^s = 1 + s q(s), where q of degree 4 meets (2^s - 1) / s at the
// five Chebyshev nodes of [-1/8, 1/8]. (The constants are in powers of r.)
[[gnu::always_inline]] inline void PowerOfTwo(Lane* x_inout) {
  constexpr double kMost = 60;
  constexpr double kToInteger = 6755399441055744;  // 1.5 2^52: the sum's last bits are n
  const Lane most = Lane{} + kMost;
  Lane x = *x_inout;
  x = x < most ? x : most;
  x = x > -most ? x : -most;
  const Lane shifted = x + kToInteger;
  const Lane r = x - (shifted - kToInteger);
  Lane q = 1.3023962406311187e-06 * r + 3.7582570363487052e-05;
  q = q * r + 8.6725167970297542e-04;
  q = q * r + 1.5014155950323113e-02;
  q = q * r + 1.7328679513998629e-01;
  q = q * r + 1.0;
  q *= q;
  q *= q;
  *x_inout = reinterpret_cast<Lane>(reinterpret_cast<LaneBits>(q) +
                                    (reinterpret_cast<LaneBits>(shifted) << 52));
}

// c' = c sigmoid(f) + sigmoid(i) tanh(j) and h' = tanh(c') sigmoid(o), each over one denominator;
// sigmoid(z) = 1 / (1 + e^-z), tanh(z) = (1 - e^-2z) / (1 + e^-2z).
[[gnu::always_inline]] inline void Cell(Lane i, Lane j, Lane f, Lane o, double* cell,
                                        double* next) {
  PowerOfTwo(&i);
  PowerOfTwo(&j);
  PowerOfTwo(&f);
  PowerOfTwo(&o);
  const Lane in = (1.0 + i) * (1.0 + j);
  const Lane forget = 1.0 + f;
  const Lane c = (At(cell) * in + (1.0 - j) * forget) / (forget * in);
  At(cell) = c;
  Lane e = c * (-2 * kLog2E);
  PowerOfTwo(&e);
  At(next) = (1.0 - e) / ((1.0 + e) * (1.0 + o));
}

// The weight of one gate for all lanes of a register.
[[gnu::always_inline]] inline auto Weight(const double* weights, long gate) {
  if constexpr (kWeightCopies == 1) {
    return weights[gate];
  } else {
    return At(weights + gate * kWeightCopies);
  }
}

template <long kBlock>
[[gnu::always_inline]] inline void Accumulate(Lane (&z)[4][kBlock], const double* weights,
                                              const double* rows, long count, long stride) {
  const double* end = rows + count * stride;
  for (; rows != end; weights += 4 * kWeightCopies, rows += stride) {
#pragma GCC unroll 8
    for (long v = 0; v < kBlock; ++v) {
      const Lane h = At(rows + v * kWidth);
#pragma GCC unroll 4
      for (long g = 0; g < 4; ++g) z[g][v] += Weight(weights, g) * h;
    }
  }
}

template <long kBlock>
[[gnu::always_inline]] inline void StepBlock(const LstmStep& step, long unit, long lane) {
  Lane z[4][kBlock];
#pragma GCC unroll 4
  for (long g = 0; g < 4; ++g) {
#pragma GCC unroll 8
    for (long v = 0; v < kBlock; ++v) z[g][v] = Lane{} + step.base[4 * unit + g];
  }
  const double* weights = step.weights + unit * 4 * kWeightCopies * (step.below_rows + step.units);
  Accumulate<kBlock>(z, weights, step.below + lane, step.below_rows, step.stride);
  Accumulate<kBlock>(z, weights + 4 * kWeightCopies * step.below_rows, step.own + lane, step.units,
                     step.stride);
  const long place = unit * step.stride + lane;
#pragma GCC unroll 8
  for (long v = 0; v < kBlock; ++v) {
    Cell(z[0][v], z[1][v], z[2][v], z[3][v], step.cell + place + v * kWidth,
         step.next + place + v * kWidth);
  }
}

// What is left after the whole blocks, fewer than kBlock registers.
template <long kBlock>
[[gnu::always_inline]] inline void StepRest(const LstmStep& step, long unit, long lane) {
  if constexpr (kBlock > 0) {
    if (lane + kBlock * kWidth <= step.lanes) {
      StepBlock<kBlock>(step, unit, lane);
    } else {
      StepRest<kBlock - 1>(step, unit, lane);
    }
  }
}

void StepAllLanes(const LstmStep& step) noexcept {
  constexpr long kBlock = PALPATE_LANE_BLOCK;
  for (long unit = 0; unit < step.units; ++unit) {
    long lane = 0;
    for (; lane + kBlock * kWidth <= step.lanes; lane += kBlock * kWidth) {
      StepBlock<kBlock>(step, unit, lane);
    }
    StepRest<kBlock - 1>(step, unit, lane);
  }
}

}  // namespace

extern const LstmKernel PALPATE_LSTM_KERNEL;
const LstmKernel PALPATE_LSTM_KERNEL = {PALPATE_LSTM_NAME, kWidth, kWeightCopies, StepAllLanes};

}  // namespace palpate
