#include "slave/tactile/network/lstm_kernel.h"

#include <array>

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

}  // namespace

std::span<const LstmKernel> LstmKernels() noexcept {
  static const Runnable runnable;
  return {runnable.kernels.data(), runnable.count};
}

}  // namespace palpate
