// Thread priorities: haptic loop first, then link, sensing and everything else.
#pragma once

#include <functional>
#include <string>

namespace palpate {

// SCHED_FIFO priorities, of 1 to 99.
inline constexpr int kHapticPriority = 80;   // the 1 kHz loop
inline constexpr int kLinkPriority = 40;     // commands, states, manipulator, watchdogs
inline constexpr int kDoorPriority = 35;     // admission control, above readers, against floods
inline constexpr int kReadingPriority = 30;  // readers of network data
inline constexpr int kSensingPriority = 20;  // images

// Sets timer slack 1 ns and SCHED_FIFO at `priority` for the calling thread, not for threads that
// it starts. Returns what the system refused, as text, for example without permission; else empty.
std::string MakeThreadRealtime(int priority);

// Calls `make` in a thread at `priority` that all threads started in it inherit, such as those of a
// library. Without permission they stay ordinary.
void MakeWithRealtimeThreads(int priority, const std::function<void()>& make);
// Gives the calling thread ordinary priority until the end of the scope.
class OrdinaryPriority {
 public:
  OrdinaryPriority();
  ~OrdinaryPriority();
  OrdinaryPriority(const OrdinaryPriority&) = delete;
  OrdinaryPriority& operator=(const OrdinaryPriority&) = delete;

 private:
  int policy_ = 0, priority_ = 0;
};

}  // namespace palpate
