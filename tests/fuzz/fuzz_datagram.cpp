// Datagrams of arbitrary senders.
#include "tests/shared/link/datagram_sequence.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  palpate::RunDatagrams(palpate::Choices({data, size}));
  return 0;
}
