// Fuzzes sequences of events at the haptic loop.
#include "tests/master/haptics/hand_sequence.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  palpate::RunHand(palpate::Choices({data, size}));
  return 0;
}
