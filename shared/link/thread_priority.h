// Who goes first when the machine has more to do than it can: what holds a hand or a tool, then
// what carries their words, then the eyes, then everything else.
#pragma once

#include <string>

namespace palpate {

// SCHED_FIFO priorities, of 1 to 99.
inline constexpr int kHapticPriority = 80;   // the 1 kHz loop
inline constexpr int kLinkPriority = 40;     // commands, states, the arm, the watchdogs
inline constexpr int kReadingPriority = 30;  // what comes from the network
inline constexpr int kEyesPriority = 20;     // pictures

// For the calling thread, not for those it starts: timer slack 1 ns, SCHED_FIFO at `priority`. In
// words what was refused, as it is to whoever lacks the permission; empty: nothing.
std::string MakeThreadRealtime(int priority);

}  // namespace palpate
