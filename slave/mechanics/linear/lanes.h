// Vector types that the compiler translates to the machine's vector instructions, and a macro for
// the few kernels that are compiled for several instruction sets.
#pragma once

#include <array>

// Compiles a function for the baseline, AVX with fused products, and AVX-512; the loader selects a
// version. Only for free functions; their callees must be inlined. Not used with sanitizers, which
// start after the loader.
#if defined(__x86_64__) && !defined(__AVX512F__) && !defined(PALPATE_SANITIZED)
#define PALPATE_DISPATCHED __attribute__((target_clones("default", "fma", "avx512f")))
#else
#define PALPATE_DISPATCHED
#endif
#define PALPATE_INLINE [[gnu::always_inline]] inline

namespace palpate::fem {

// Four doubles at any address; eight doubles for eight elements.
using Double4 [[gnu::vector_size(32), gnu::may_alias, gnu::aligned(8)]] = double;
using Double8 [[gnu::vector_size(64)]] = double;
using Mask8 [[gnu::vector_size(64)]] = long long;
inline constexpr int kLanes = 8;
using Lanes3x3 = std::array<std::array<Double8, 3>, 3>;
// Single precision: four numbers at any address; four numbers of each of four rows.
using Float8 [[gnu::vector_size(32)]] = float;
using LooseFloat8 [[gnu::vector_size(32), gnu::may_alias, gnu::aligned(4)]] = float;
using LooseFloat16 [[gnu::vector_size(64), gnu::may_alias, gnu::aligned(4)]] = float;
using Float4 [[gnu::vector_size(16), gnu::may_alias, gnu::aligned(4)]] = float;
using Float16 [[gnu::vector_size(64), gnu::may_alias]] = float;

// Passes by value: clang assumes that a reference has the alignment of its type, which faults where
// the loader selects the baseline.
PALPATE_INLINE Double4 Load4(const double* p) {
  return *reinterpret_cast<const Double4*>(p);
}
PALPATE_INLINE void Store4(double* p, const Double4& values) {
  *reinterpret_cast<Double4*>(p) = values;
}
PALPATE_INLINE Float4 LoadSingles(const float* p) {
  return *reinterpret_cast<const Float4*>(p);
}
PALPATE_INLINE void StoreSingles(float* p, const Float4& values) {
  *reinterpret_cast<Float4*>(p) = values;
}

}  // namespace palpate::fem
