// Thread priorities: haptic loop first, then watchdogs and devices, sensing, all threads that call
// gRPC, and everything else. Sensing precedes the network, so that it keeps its period under
// network load. The threads that call gRPC have one priority: its mutexes do not inherit priority
// and waiting threads spin, so a waiting thread of higher priority would keep the owner from the
// processor.
#pragma once

#include <functional>
#include <string>

namespace palpate {

// SCHED_FIFO priorities, of 1 to 99.
inline constexpr int kHapticPriority = 80;     // the 1 kHz loop
inline constexpr int kLinkPriority = 40;       // watchdogs, devices
inline constexpr int kSensingPriority = 30;    // images and tactile samples
inline constexpr int kAdmissionPriority = 25;  // admission control, above readers, against floods
inline constexpr int kReadingPriority = 20;    // commands, states, all that calls gRPC

// Sets timer slack 1 ns and SCHED_FIFO at `priority` for the calling thread, not for threads that
// it starts. Returns what the system refused, as text, for example without permission; else empty.
std::string MakeThreadRealtime(int priority);

// Calls `make` in a thread at `priority` that all threads started in it inherit, such as those of a
// library. Without permission they stay ordinary.
void MakeWithRealtimeThreads(int priority, const std::function<void()>& make);
// Gives the calling thread another priority until the end of the scope. Without permission it keeps
// its own.
class ScopedPriority {
 public:
  ScopedPriority(const ScopedPriority&) = delete;
  ScopedPriority& operator=(const ScopedPriority&) = delete;

 protected:
  ScopedPriority(int policy, int priority);
  ~ScopedPriority();

 private:
  int policy_ = 0, priority_ = 0;
};
// OrdinaryPriority is for threads that process bulk data.
class OrdinaryPriority : private ScopedPriority {
 public:
  OrdinaryPriority();
};
// ReadingPriority is for threads that read network data. Any thread that waits in gRPC may be the
// one that gRPC lets read the connections of all others, the operator's included.
class ReadingPriority : private ScopedPriority {
 public:
  ReadingPriority();
};

}  // namespace palpate
