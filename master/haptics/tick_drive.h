// Runs the ticks of a session: on the device's own thread where it has one, else on the caller's.
// The caller also takes over while the device's thread is silent, so that commands continue.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <stop_token>

#include "master/device/device.h"
#include "master/haptics/periodic.h"

namespace palpate {

class TickDrive {
 public:
  // `tick` is called by one thread at a time. It returns false when it needs no more. Real-time
  // safe. `device` must outlive this object.
  TickDrive(Device& device, std::function<bool(Time)> tick);
  ~TickDrive();
  TickDrive(const TickDrive&) = delete;
  TickDrive& operator=(const TickDrive&) = delete;

  // Runs ticks for `length`, until `stop`, or until a tick returns false.
  void Run(Clock::duration length, const std::stop_token& stop, PeriodicStats* stats) noexcept;
  // On return no tick is running, nor will be. Idempotent.
  void Stop();

 private:
  // Runs a tick unless another thread is inside one. False: another is.
  bool TryTick(Time now) noexcept;
  bool Supervise() noexcept;

  Device& device_;
  const std::function<bool(Time)> tick_;
  const Device::Tick on_device_;
  std::atomic_flag busy_;  // a thread is inside a tick
  std::atomic<bool> wanted_{false};
  std::atomic<Time> driven_at_{Time{}};  // of the last tick on the device's thread
  std::atomic<std::uint64_t> ticks_{0};
  static_assert(std::atomic<Time>::is_always_lock_free);
  bool driven_;  // last: the device may tick from here on
};

}  // namespace palpate
