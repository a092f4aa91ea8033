// Count of received datagrams of the peer.
#pragma once

#include <cstdint>

namespace palpate {

// Counts authentic datagrams that are newer than all before.
struct DatagramCount {
  std::uint64_t newest = 0;  // counter in the newest one: how many the peer had sent by then
  std::uint64_t received = 0;
};

}  // namespace palpate
