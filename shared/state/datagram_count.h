// Count of received datagrams of the peer.
#pragma once

#include <cstdint>

namespace palpate {

// Counts authentic datagrams that are newer than all before.
struct DatagramCount {
  std::uint64_t newest = 0;  // counter of the newest: the number sent up to it
  std::uint64_t received = 0;
};

}  // namespace palpate
