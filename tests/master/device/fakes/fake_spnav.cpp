// A stand-in for libspnav 1.0 together with spacenavd 1.1, on the injected clock.
//
// Events come while the puck is deflected, one with zeros when it is back, and then none. An
// unplugged device reports its removal in a device event, and sends no zeros. Button numbers have
// holes.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <deque>

#include <sys/eventfd.h>
#include <unistd.h>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {

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
    int type, op, id, device, usb[2];
  } device;
};

namespace {

using Guard = std::lock_guard<std::recursive_mutex>;

constexpr double kFull = 350;       // counts of full deflection
constexpr double kFullWay = 0.002;  // [m]
constexpr double kPeriod = 0.016;   // of the device's reports [s]
constexpr char kName[] = "SpaceMouse Pro";

struct Spnav : Core {
  int connection = -1;  // a descriptor that lives as long as the daemon
  std::deque<SpnavEvent> events;
  double last_motion = 0;
  bool moving = false;
  unsigned reported = 0;

  ~Spnav() override { Close(); }
  std::map<std::string, std::string> Defaults() const override { return {}; }
  void OnReset() override {
    const Guard guard(mutex);
    Close();
    events.clear();
    moving = false;
    reported = 0;
    last_motion = time;
  }
  void OnPlug() override {
    moving = false;
    SpnavEvent event{};
    event.device = {3, plugged ? 0 : 1, 0, 0x20a, {0x046d, 0xc62b}};
    events.push_back(event);
  }
  void Close() {
    if (connection >= 0) close(connection);
    connection = -1;
  }
  void OnStep(double) override {
    if (!plugged || frozen) return;
    for (int i = 0; i < 32; ++i) {
      if (((buttons ^ reported) >> i & 1) == 0) continue;
      SpnavEvent event{};
      event.button = {2, static_cast<int>(buttons >> i & 1), i};
      events.push_back(event);
    }
    reported = buttons;
    if (time - last_motion < kPeriod - 1e-9) return;
    const auto counts = [this](int axis) {
      return static_cast<int>(std::lround(kFull * std::clamp(p[axis] / kFullWay, -1.0, 1.0)));
    };
    SpnavEvent event{};
    event.motion = {1, counts(0), counts(1), counts(2), 0, 0, 0, 0, nullptr};
    event.motion.period = static_cast<unsigned>(std::lround(1000 * (time - last_motion)));
    const bool deflected = counts(0) != 0 || counts(1) != 0 || counts(2) != 0;
    if (!deflected && !moving) return;
    events.push_back(event);
    moving = deflected;
    last_motion = time;
  }
};

Spnav spnav;

}  // namespace

Core& TheCore() {
  return spnav;
}

namespace {
const Start start(spnav, "SPNAV");
}

FAKE_EXPORT int spnav_open() {
  const Guard guard(spnav.mutex);
  if (const int code = spnav.Enter(__func__)) return code;
  if (spnav.connection < 0) spnav.connection = eventfd(0, EFD_CLOEXEC);
  return spnav.connection < 0 ? -1 : 0;
}

FAKE_EXPORT int spnav_close() {
  const Guard guard(spnav.mutex);
  spnav.Close();
  return 0;
}

FAKE_EXPORT int spnav_fd() {
  const Guard guard(spnav.mutex);
  return spnav.connection;
}

FAKE_EXPORT int spnav_poll_event(SpnavEvent* event) {
  const Guard guard(spnav.mutex);
  if (spnav.Enter(__func__) || spnav.events.empty()) return 0;
  *event = spnav.events.front();
  spnav.events.pop_front();
  if (event->type == 1) event->motion.data = &event->motion.x;
  return event->type;
}

FAKE_EXPORT int spnav_dev_name(char* name, int room) {
  const Guard guard(spnav.mutex);
  if (spnav.Enter(__func__) || !spnav.plugged) return -1;
  if (name && room > 0) {
    std::strncpy(name, kName, static_cast<std::size_t>(room));
    name[room - 1] = 0;
  }
  return static_cast<int>(std::strlen(kName));
}

}  // namespace palpate::fakes
