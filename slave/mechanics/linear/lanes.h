// Vector types that the compiler translates to the machine's vector instructions, and a macro for
// the few kernels that are compiled for several instruction sets.
#pragma once

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

// Passes by value: clang assumes that a reference has the alignment of its type, which faults where
// the loader selects the baseline.
PALPATE_INLINE Double4 Load4(const double* p) {
  return *reinterpret_cast<const Double4*>(p);
}
PALPATE_INLINE void Store4(double* p, const Double4& values) {
  *reinterpret_cast<Double4*>(p) = values;
}

}  // namespace palpate::fem
