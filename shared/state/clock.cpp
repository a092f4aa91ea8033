#include "shared/state/clock.h"

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

}  // namespace

Clock::time_point Clock::now() noexcept {
  const Anchor& a = anchor();
  return time_point(a.wall + (std::chrono::steady_clock::now() - a.steady));
}

std::chrono::steady_clock::time_point Clock::ToSteady(time_point t) noexcept {
  const Anchor& a = anchor();
  return a.steady + (t.time_since_epoch() - a.wall);
}

}  // namespace palpate
