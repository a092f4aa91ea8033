// Waits for a condition that another thread or program fulfils.
#pragma once

#include <chrono>
#include <thread>

namespace palpate {

// Time after which a test fails: ten times the longest wait that occurs.
inline constexpr std::chrono::seconds kLiveness{120};

// Looks again until `condition` holds or the time is over.
template <class Condition>
bool Eventually(const Condition& condition) {
  const auto end = std::chrono::steady_clock::now() + kLiveness;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace palpate
