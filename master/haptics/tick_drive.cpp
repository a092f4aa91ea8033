#include "master/haptics/tick_drive.h"

#include <cmath>
#include <utility>

namespace palpate {

TickDrive::TickDrive(Device& device, std::function<bool(Time)> tick)
    : device_(device),
      tick_(std::move(tick)),
      on_device_([this](Time now) {
        if (TryTick(now)) driven_at_ = now;
      }),
      driven_(device.StartTicks(&on_device_)) {}

TickDrive::~TickDrive() {
  Stop();
}

void TickDrive::Stop() {
  if (driven_) device_.StopTicks();
  driven_ = false;
}

bool TickDrive::TryTick(Time now) noexcept {
  if (busy_.test_and_set(std::memory_order_acquire)) return false;
  if (wanted_) {
    wanted_ = tick_(now);
    ++ticks_;
  }
  busy_.clear(std::memory_order_release);
  return true;
}

bool TickDrive::Supervise() noexcept {
  const Time now = Clock::now();
  const bool silent = SecondsBetween(driven_at_, now) >= Device::kLetGoAfter;
  if (!driven_ || silent) TryTick(now);
  return wanted_;
}

void TickDrive::Run(Clock::duration length, const std::stop_token& stop,
                    PeriodicStats* stats) noexcept {
  driven_at_ = Clock::now();
  ticks_ = 0;
  wanted_ = true;
  RunPeriodically(length, stop, stats, [this] { return Supervise(); });
  if (!driven_) return;
  // Counts the device's ticks at its own rate, not the periods of this thread.
  const double usual = 1 / std::chrono::duration<double>(kHapticPeriod).count();
  const double rate = device_.limits().rate;
  const double periods = stats->duration * (rate > 0 ? rate : usual);
  stats->ticks = ticks_;
  const auto wanted = static_cast<std::uint64_t>(std::llround(periods));
  stats->missed = wanted > stats->ticks ? wanted - stats->ticks : 0;
}

}  // namespace palpate
