#define PALPATE_LANE_BYTES 16
#define PALPATE_LANE_BLOCK 3
// Spreading a number over a register costs this instruction set two instructions: weights come
// spread already.
#define PALPATE_WEIGHT_COPIES 2
#include "slave/tactile/network/lstm_kernel_body.h"

namespace palpate {

extern const LstmKernel kLstmKernelBaseline;
const LstmKernel kLstmKernelBaseline = {"baseline", kWidth, kWeightCopies, StepAllLanes};

}  // namespace palpate
