// 3Dconnexion SpaceMouse through libspnav and its daemon spacenavd: deflection of the cap is
// velocity. It has no force. The first button that is ever pressed is the dead-man's switch, since
// the numbers of buttons have holes.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "master/device/rate/rate_device.h"
#include "master/device/search/driver.h"

namespace palpate {

// An event of libspnav, in its layout.
union SpnavEvent {
  int type;
  struct {
    int type, x, y, z, rx, ry, rz;
    unsigned period;
    int* data;
  } motion;
  struct {
    int type, press, number;
  } button;
  struct {
    int type, removed, id;
  } device;
  int room[32];  // larger events of other releases
};

struct SpnavApi {
  // Returns why it cannot be used; empty: every function is set.
  std::string Load(const LibrarySearch& search);

  int (*open)() = nullptr;
  int (*close)() = nullptr;
  int (*fd)() = nullptr;
  int (*poll_event)(SpnavEvent*) = nullptr;
  int (*device_name)(char*, int) = nullptr;  // optional: since 1.0
};

class SpaceMouseSource final : public RateSource {
 public:
  // `folders` of the library, before the usual ones. Throws DeviceUnavailable.
  explicit SpaceMouseSource(std::vector<std::filesystem::path> folders);
  ~SpaceMouseSource() override;
  SpaceMouseSource(const SpaceMouseSource&) = delete;
  SpaceMouseSource& operator=(const SpaceMouseSource&) = delete;

  RateInput Poll(Time now) override;
  [[nodiscard]] std::string description() const override { return description_; }

 private:
  void Take(const SpnavEvent& event, Time now);

  SpnavApi api_;
  std::string description_;
  Eigen::Vector3d counts_{0, 0, 0};  // frame M
  double full_scale_ = 350;          // counts at full deflection; grows with what was seen
  std::vector<int> known_buttons_;   // numbers, in the order of their first press
  std::uint32_t buttons_ = 0;        // bit: place in known_buttons_
  Time moved_at_{};                  // of the last motion
  bool gone_ = false, unplugged_ = false;
};

// The row of the table of drivers.
Driver SpaceMouseDriver();

}  // namespace palpate
