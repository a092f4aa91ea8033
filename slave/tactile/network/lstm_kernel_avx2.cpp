#define PALPATE_LANE_BYTES 32
#define PALPATE_LANE_BLOCK 3
#define PALPATE_WEIGHT_COPIES 1
#include "slave/tactile/network/lstm_kernel_body.h"

namespace palpate {

extern const LstmKernel kLstmKernelAvx2;
const LstmKernel kLstmKernelAvx2 = {"avx2", kWidth, kWeightCopies, StepAllLanes};

}  // namespace palpate
