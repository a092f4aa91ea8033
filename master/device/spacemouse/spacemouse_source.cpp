#include "master/device/spacemouse/spacemouse_source.h"

#include <algorithm>
#include <array>

#include <poll.h>
#include <spnav.h>

#include "master/device/search/driver.h"

namespace palpate {
namespace {

constexpr double kMotionLasts = 0.250;  // without an event: a deflected cap repeats them [s]
constexpr int kMaxEvents = 64;          // taken per poll
constexpr double kDeadZone = 0.08;      // of the full deflection: the cap does not rest at zero [-]
constexpr std::size_t kMaxButtons = 32;

double WithoutDeadZone(double share) {
  const double beyond = std::abs(share) - kDeadZone;
  return beyond <= 0 ? 0 : std::copysign(std::min(beyond / (1 - kDeadZone), 1.0), share);
}

}  // namespace

SpaceMouseSource::SpaceMouseSource() {
  if (spnav_open() == -1) {
    throw DeviceUnavailable("spacemouse", "spacenavd does not answer: is it running?");
  }
  std::array<char, 128> name{};
  const bool named = spnav_dev_name(name.data(), static_cast<int>(name.size()) - 1) > 0;
  description_ = "spacemouse: " + std::string(named ? name.data() : "unknown model");
}

SpaceMouseSource::~SpaceMouseSource() {
  spnav_close();
}

RateInput SpaceMouseSource::Poll(Time now) {
  pollfd line{spnav_fd(), POLLIN, 0};
  if (line.fd < 0 || (poll(&line, 1, 0) > 0 && (line.revents & ~POLLIN) != 0)) gone_ = true;
  spnav_event event{};
  for (int i = 0; !gone_ && i < kMaxEvents && spnav_poll_event(&event) != 0; ++i)
    TakeEvent(event, now);
  if (SecondsBetween(moved_at_, now) > kMotionLasts) counts_.setZero();
  RateInput input;
  for (int i = 0; i < 3; ++i) input.share[i] = WithoutDeadZone(counts_[i] / full_scale_);
  input.buttons = buttons_;
  input.engaged = (buttons_ & 1U) != 0;
  if (gone_ || unplugged_) {
    input.fault = DeviceFault::kUnplugged;
    input.cause = gone_ ? "spacenavd has closed the connection" : "spacenavd reports its removal";
  }
  return input;
}

// The library's z points away from the operator.
void SpaceMouseSource::TakeEvent(const spnav_event& event, Time now) {
  if (event.type == SPNAV_EVENT_MOTION) {
    const auto& motion = event.motion;
    counts_ = Eigen::Vector3d(motion.x, motion.y, -motion.z);
    moved_at_ = now;
    full_scale_ = std::max(full_scale_, counts_.cwiseAbs().maxCoeff());
  } else if (event.type == SPNAV_EVENT_DEV) {
    unplugged_ = event.dev.op == SPNAV_DEV_RM;
    counts_.setZero();
    buttons_ = 0;
  } else if (event.type == SPNAV_EVENT_BUTTON) {
    auto known = std::ranges::find(known_buttons_, event.button.bnum);
    if (known == known_buttons_.end()) {
      if (known_buttons_.size() >= kMaxButtons) return;
      known_buttons_.push_back(event.button.bnum);
      known = known_buttons_.end() - 1;
    }
    const auto bit = std::uint32_t{1} << static_cast<unsigned>(known - known_buttons_.begin());
    buttons_ = event.button.press != 0 ? buttons_ | bit : buttons_ & ~bit;
  }
}

}  // namespace palpate
