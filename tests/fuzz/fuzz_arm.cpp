// Orders of events at the operator's port.
#include "tests/slave/live/arm_sequence.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  palpate::RunArm(palpate::Choices({data, size}));
  return 0;
}
