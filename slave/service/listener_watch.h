// Whether somebody still answers at the door: a listener that ran out of descriptors may go deaf
// for good while its process lives and says that it serves.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "shared/link/loopback.h"

namespace palpate {

// Connects as a stranger would. True: a byte, or an end, came back within `patience`. An HTTP/2
// server speaks first, a TLS server answers what is no hello.
bool Answers(const Endpoint& endpoint, std::chrono::milliseconds patience);

class ListenerWatch {
 public:
  struct Options {
    std::chrono::milliseconds period{5000}, patience{2000};
    int misses = 3;  // in a row: it is deaf
  };
  // Calls `on_deaf` from a thread of its own, once.
  ListenerWatch(Endpoint endpoint, std::function<void()> on_deaf, const Options& options);

 private:
  std::jthread thread_;
};

}  // namespace palpate
