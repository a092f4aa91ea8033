#include "shared/state/clock.h"

#include <algorithm>
#include <utility>

#include "shared/state/driven_clock.h"

namespace palpate {
namespace {

struct Anchor {
  std::chrono::steady_clock::time_point steady = std::chrono::steady_clock::now();
  std::chrono::nanoseconds wall = std::chrono::duration_cast<std::chrono::nanoseconds>(
      std::chrono::system_clock::now().time_since_epoch());
};

const Anchor& anchor() noexcept {
  static const Anchor anchor;
  return anchor;
}

constinit thread_local Time* driven = nullptr;  // null: the machine's clock

}  // namespace

Clock::time_point Clock::now() noexcept {
  if (driven != nullptr) return *driven;
  const Anchor& a = anchor();
  return time_point(a.wall + (std::chrono::steady_clock::now() - a.steady));
}

std::chrono::steady_clock::time_point Clock::ToSteady(time_point t) noexcept {
  const Anchor& a = anchor();
  return a.steady + (t.time_since_epoch() - a.wall);
}

bool DrivenClock::is_active() noexcept {
  return driven != nullptr;
}

bool DrivenClock::Reach(Time t) noexcept {
  if (driven == nullptr) return false;
  *driven = std::max(*driven, t);
  return true;
}

DrivenClock::DrivenClock() noexcept : former_(std::exchange(driven, &now_)) {}

DrivenClock::~DrivenClock() {
  driven = former_;
}

}  // namespace palpate
