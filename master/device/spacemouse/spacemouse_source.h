// 3Dconnexion SpaceMouse through libspnav and its daemon spacenavd: deflection of the cap is
// velocity. It has no force. The first button that is ever pressed is the dead-man's switch, since
// the numbers of buttons have holes. Part of palpate-devices.so.
#pragma once

#include <string>
#include <vector>

#include "master/device/rate/rate_device.h"

union spnav_event;

namespace palpate {

class SpaceMouseSource final : public RateSource {
 public:
  // Throws DeviceUnavailable.
  SpaceMouseSource();
  ~SpaceMouseSource() override;
  SpaceMouseSource(const SpaceMouseSource&) = delete;
  SpaceMouseSource& operator=(const SpaceMouseSource&) = delete;

  RateInput Poll(Time now) override;
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  void TakeEvent(const spnav_event& event, Time now);

  std::string description_;
  Eigen::Vector3d counts_{0, 0, 0};  // frame M
  double full_scale_ = 350;          // counts at full deflection; grows with what was seen
  std::vector<int> known_buttons_;   // numbers, in the order of their first press
  std::uint32_t buttons_ = 0;        // bit: place in known_buttons_
  Time moved_at_{};                  // of the last motion
  bool gone_ = false, unplugged_ = false;
};

}  // namespace palpate
