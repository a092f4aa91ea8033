// Checks whether the listener still responds: after running out of descriptors it may be
// unresponsive for good while its process lives and reports that it serves.
#pragma once

#include <chrono>
#include <functional>
#include <thread>

#include "shared/link/loopback.h"
#include "slave/service/admission/acceptor.h"

namespace palpate {

// Connects and sends a preface. True: a byte, or an end, came back within `patience`. TLS answers
// an incomplete hello with an alert.
bool Answers(const Endpoint& endpoint, Greeting greeting, std::chrono::milliseconds patience);

class ListenerWatch {
 public:
  struct Options {
    std::chrono::milliseconds period{5000}, patience{2000};
    int misses = 3;  // in a row: it is deaf
    Greeting greeting = Greeting::kHttp2;
    std::function<void(int missed)> on_missed = {};  // so many in a row; empty: nothing
  };
  // Calls `on_deaf` once, from a separate thread.
  ListenerWatch(Endpoint endpoint, std::function<void()> on_deaf, const Options& options);

 private:
  std::jthread thread_;
};

}  // namespace palpate
