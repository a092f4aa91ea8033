#define PALPATE_LANE_BYTES 64
#define PALPATE_LANE_BLOCK 4
#define PALPATE_WEIGHT_COPIES 1
#include "slave/tactile/network/lstm_kernel_body.h"

namespace palpate {

extern const LstmKernel kLstmKernelAvx512;
const LstmKernel kLstmKernelAvx512 = {"avx512", kWidth, kWeightCopies, StepAllLanes};

}  // namespace palpate
