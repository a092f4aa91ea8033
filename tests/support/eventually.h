// Waits for what another thread or program does.
#pragma once

#include <chrono>
#include <thread>

namespace palpate {

// How long anything may take before a test gives up: ten times what the slowest needs.
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
