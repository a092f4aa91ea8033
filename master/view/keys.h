// Keys of the terminal: Enter is the emergency stop, `r` and Enter resets it. Without a terminal
// there are no keys.
#pragma once

#include <functional>
#include <thread>

namespace palpate {

class Keys {
 public:
  // Both are called on a separate thread.
  Keys(std::function<void()> stop, std::function<void()> reset);

 private:
  std::jthread thread_;
};

}  // namespace palpate
