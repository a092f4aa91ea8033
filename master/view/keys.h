// The keys of the operator's terminal: Enter is the emergency stop, `r` and Enter resets it. Where
// there is no terminal, there are none.
#pragma once

#include <functional>
#include <thread>

namespace palpate {

class Keys {
 public:
  // Both are called from a thread of its own.
  Keys(std::function<void()> stop, std::function<void()> reset);

 private:
  std::jthread thread_;
};

}  // namespace palpate
