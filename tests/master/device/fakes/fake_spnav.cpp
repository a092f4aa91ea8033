// A stand-in for libspnav 1.0 together with spacenavd 1.1.
//
// Events come while the puck is deflected, one with zeros when it is back, and then none. An
// unplugged device reports its removal in a device event, and sends no zeros. Button numbers have
// holes.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <thread>

#include <sys/socket.h>
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
using Packet = std::array<std::int32_t, 8>;

enum : std::int32_t { kMotion, kPress, kRelease, kDevice };
constexpr double kFull = 350;       // counts of full deflection
constexpr double kFullWay = 0.002;  // [m]
constexpr char kName[] = "SpaceMouse Pro";

struct Spnav : Core {
  int own = -1, daemon = -1;  // the two ends of the connection
  double last_motion = 0;
  bool moving = false;
  unsigned reported = 0;
  std::jthread pump;

  ~Spnav() override { Close(); }

  // period: of the device's reports [s]. daemon: 0 closes the connection and accepts none.
  std::map<std::string, std::string> Defaults() const override {
    return {{"period", "0.016"}, {"daemon", "1"}};
  }
  void OnReset() override {
    Close();
    const Guard guard(mutex);
    moving = false;
    reported = 0;
    last_motion = time;
  }
  void OnOption(const std::string& name) override {
    if (name == "daemon" && Number("daemon") == 0) CloseEnd(&daemon);
  }
  void OnPlug() override {
    moving = false;
    Send({kDevice, plugged ? 0 : 1, 0, 0x20a, 0x046d, 0xc62b, 0, 0});
  }

  static void CloseEnd(int* end) {
    if (*end >= 0) close(*end);
    *end = -1;
  }
  void Close() {
    pump.request_stop();
    if (pump.joinable()) pump.join();
    pump = {};
    const Guard guard(mutex);
    CloseEnd(&daemon);
    CloseEnd(&own);
  }
  // Lets time pass.
  void Pump(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      const Guard guard(mutex);
      Sync();
    }
  }
  void Send(const Packet& packet) const {
    send(daemon, packet.data(), sizeof packet, MSG_NOSIGNAL | MSG_DONTWAIT);
  }

  void OnStep(double) override {
    if (!plugged || frozen) return;
    for (int i = 0; i < 32; ++i) {
      if ((buttons ^ reported) >> i & 1) Send({buttons >> i & 1 ? kPress : kRelease, i});
    }
    reported = buttons;
    if (time - last_motion < Number("period") - 1e-9) return;
    Packet packet{kMotion};
    bool deflected = false;
    for (int i = 0; i < 3; ++i) {
      const auto counts =
          static_cast<std::int32_t>(std::lround(kFull * std::clamp(p[i] / kFullWay, -1.0, 1.0)));
      packet[static_cast<std::size_t>(i) + 1] = counts;
      deflected = deflected || counts != 0;
    }
    if (!deflected && !moving) return;
    packet[7] = static_cast<std::int32_t>(std::lround(1000 * (time - last_motion)));
    Send(packet);
    moving = deflected;
    last_motion = time;
  }
};

Spnav spnav;

int Read(int fd, SpnavEvent* event) {
  Packet packet{};
  if (recv(fd, packet.data(), sizeof packet, MSG_DONTWAIT) != sizeof packet) return 0;
  switch (packet[0]) {
    case kMotion:
      event->motion = {1,         packet[1], packet[2], packet[3],
                       packet[4], packet[5], packet[6], static_cast<unsigned>(packet[7]),
                       nullptr};
      event->motion.data = &event->motion.x;
      break;
    case kPress:
    case kRelease:
      event->button = {2, packet[0] == kPress, packet[1]};
      break;
    default:
      event->device = {3, packet[1], packet[2], packet[3], {packet[4], packet[5]}};
  }
  return event->type;
}

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
  int pair[2];
  if (spnav.own >= 0 || spnav.Number("daemon") == 0 ||
      socketpair(AF_UNIX, SOCK_STREAM, 0, pair) != 0)
    return -1;
  spnav.own = pair[0];
  spnav.daemon = pair[1];
  spnav.pump = std::jthread([](const std::stop_token& stop) { spnav.Pump(stop); });
  return 0;
}

FAKE_EXPORT int spnav_close() {
  const Guard guard(spnav.mutex);
  spnav.Enter(__func__);
  if (spnav.own < 0) return -1;
  Spnav::CloseEnd(&spnav.own);
  return 0;
}

FAKE_EXPORT int spnav_fd() {
  const Guard guard(spnav.mutex);
  return spnav.own;
}

// 0 also where the daemon has gone: no event reports it.
FAKE_EXPORT int spnav_poll_event(SpnavEvent* event) {
  const Guard guard(spnav.mutex);
  if (spnav.Enter(__func__) || spnav.own < 0) return 0;
  return Read(spnav.own, event);
}

FAKE_EXPORT int spnav_dev_name(char* name, int room) {
  const Guard guard(spnav.mutex);
  if (spnav.Enter(__func__) || spnav.own < 0 || !spnav.plugged) return -1;
  if (name && room > 0) {
    std::strncpy(name, kName, static_cast<std::size_t>(room));
    name[room - 1] = 0;
  }
  return static_cast<int>(std::strlen(kName));
}

}  // namespace palpate::fakes
