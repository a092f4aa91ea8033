// Who goes first when the machine has more to do than it can: what holds a hand or a tool, then
// what carries their words, then the eyes, then everything else.
#pragma once

#include <functional>
#include <string>

namespace palpate {

// SCHED_FIFO priorities, of 1 to 99.
inline constexpr int kHapticPriority = 80;   // the 1 kHz loop
inline constexpr int kLinkPriority = 40;     // commands, states, the arm, the watchdogs
inline constexpr int kDoorPriority = 35;     // who may send: a flood is cut before it is read
inline constexpr int kReadingPriority = 30;  // what comes from the network
inline constexpr int kSensingPriority = 20;  // pictures

// For the calling thread, not for those it starts: timer slack 1 ns, SCHED_FIFO at `priority`. In
// words what was refused, as it is to whoever lacks the permission; empty: nothing.
std::string MakeThreadRealtime(int priority);

// Calls `make` in a thread at `priority`, whose threads, and theirs, have it, too: those of a
// library that starts them where it is first used. Where that is not permitted they stay ordinary.
void MakeWithRealtimeThreads(int priority, const std::function<void()>& make);
// For the calling thread until the end of the scope: as urgent as anything else.
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
