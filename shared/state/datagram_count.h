// What came of the other end's datagrams.
#pragma once

#include <cstdint>

namespace palpate {

// Of those that were authentic, and newer than all before.
struct DatagramCount {
  std::uint64_t newest = 0;  // its counter: so many were sent up to there
  std::uint64_t received = 0;
};

}  // namespace palpate
