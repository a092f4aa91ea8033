// A stand-in for libspnav 1.0 together with spacenavd 1.1: its clients get the daemon's packets,
// through the library's calls, or through a socket by the daemon's protocol.
//
// Events come while the puck is deflected, one with zeros when it is back, and then none. An
// unplugged device says so in a device event, and sends no zeros. Button numbers have holes.
//
// Compiled with FAKE_MISSING it lacks spnav_poll_event.
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <thread>

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
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
constexpr std::int32_t kTag = 0x7faa0000, kChangeProtocol = 0x5500, kSetMask = 0x1003,
                       kDeviceName = 0x2000, kAxes = 0x2002, kButtons = 0x2003, kProtocol = 1;
constexpr unsigned kDefaultMask = 7;  // motion, buttons and device events
constexpr double kFull = 350;         // counts of full deflection
constexpr double kFullWay = 0.002;    // [m]
constexpr double kFullTurn = 0.2;     // [rad]
constexpr double kSpring = 2000;      // that brings the puck back [N/m]
constexpr char kName[] = "SpaceMouse Pro";

struct Spnav : Core {
  struct Client {
    int fd;
    int protocol;
    unsigned mask;
  };
  std::vector<Client> clients;
  int own = -1, listening = -1;
  double last_motion = 0;
  bool moving = false;
  unsigned reported = 0;
  std::jthread pump;

  ~Spnav() override { Close(); }

  // period: of the device's reports [s]. daemon: 0 closes all connections and accepts none. socket:
  // path at which the daemon is reached.
  std::map<std::string, std::string> Defaults() const override {
    return {{"period", "0.016"}, {"daemon", "1"},     {"socket", "none"},
            {"mass", "0.05"},    {"viscosity", "20"}, {"half_x", "0.002"},
            {"half_y", "0.002"}, {"half_z", "0.002"}, {"grip_stiffness", "inf"}};
  }
  void OnReset() override {
    Close();
    const Guard guard(mutex);
    moving = false;
    reported = 0;
    last_motion = time;
  }
  bool OnOption(const std::string& name) override {
    if (name == "daemon" && Number("daemon") == 0) EndConnections();
    return name != "socket" || Listen();
  }
  void OnPlug() override {
    moving = false;
    Send({kDevice, plugged ? 0 : 1, 0, 0x20a, 0x046d, 0xc62b, 0, 0}, 4);
  }
  Eigen::Vector3d Weight() const override { return -kSpring * p; }

  void Close();
  void EndConnections();
  bool Listen();
  void Pump(const std::stop_token& stop);
  void Answer(Client& client);
  void StartPump() {
    if (!pump.joinable()) pump = std::jthread([this](const std::stop_token& stop) { Pump(stop); });
  }
  void Send(const Packet& packet, unsigned kind) const {
    for (const Client& client : clients) {
      if ((client.mask & kind) && (client.protocol > 0 || kind != 4)) {
        send(client.fd, packet.data(), sizeof packet, MSG_NOSIGNAL | MSG_DONTWAIT);
      }
    }
  }

  void OnStep(double) override {
    if (!plugged || frozen) return;
    for (int i = 0; i < 32; ++i) {
      if ((buttons ^ reported) >> i & 1) Send({buttons >> i & 1 ? kPress : kRelease, i}, 2);
    }
    reported = buttons;
    if (time - last_motion < Number("period") - 1e-9) return;
    const Eigen::AngleAxisd turn(R);
    const Eigen::Vector3d turned = turn.angle() * turn.axis();
    Packet packet{kMotion};
    bool deflected = false;
    for (int i = 0; i < 6; ++i) {
      const double part = i < 3 ? p[i] / kFullWay : turned[i - 3] / kFullTurn;
      const auto counts =
          static_cast<std::int32_t>(std::lround(kFull * std::clamp(part, -1.0, 1.0)));
      packet[static_cast<std::size_t>(i) + 1] = counts;
      deflected = deflected || counts != 0;
    }
    if (!deflected && !moving) return;
    packet[7] = static_cast<std::int32_t>(std::lround(1000 * (time - last_motion)));
    Send(packet, 1);
    moving = deflected;
    last_motion = time;
  }
};

void Spnav::Close() {
  pump.request_stop();
  if (pump.joinable()) pump.join();
  pump = {};
  const Guard guard(mutex);
  EndConnections();
  if (own >= 0) close(own);
  own = -1;
}

void Spnav::EndConnections() {
  for (const Client& client : clients) close(client.fd);
  clients.clear();
  if (listening >= 0) close(listening);
  listening = -1;
}

bool Spnav::Listen() {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, Text("socket").c_str(), sizeof address.sun_path - 1);
  listening = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  unlink(address.sun_path);
  StartPump();
  return bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0 &&
         listen(listening, 4) == 0;
}

// The daemon: lets time pass, accepts clients and answers them.
void Spnav::Pump(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    const Guard guard(mutex);
    Sync();
    pollfd wait{listening, POLLIN, 0};
    if (listening >= 0 && poll(&wait, 1, 0) > 0) {
      if (const int fd = accept(listening, nullptr, nullptr); fd >= 0)
        clients.push_back({fd, 0, 3});
    }
    for (Client& client : clients) Answer(client);
  }
}

void Spnav::Answer(Client& client) {
  Packet request{};
  const ssize_t size = recv(client.fd, request.data(), sizeof request, MSG_DONTWAIT);
  if (size < static_cast<ssize_t>(sizeof request[0]) || (request[0] & 0x7fff0000) != kTag) return;
  const std::int32_t what = request[0] & 0xff00;
  if (what == kChangeProtocol) {
    client.protocol = std::min(request[0] & 0xff, kProtocol);
    client.mask = kDefaultMask;
    const std::int32_t answer = kTag | kChangeProtocol | client.protocol;
    send(client.fd, &answer, sizeof answer, MSG_NOSIGNAL);
    return;
  }
  request[7] = 0;  // done
  switch (request[0] & 0xffff) {
    case kSetMask:
      client.mask = static_cast<unsigned>(request[1]);
      break;
    case kAxes:
      request[1] = 6;
      break;
    case kButtons:
      request[1] = 15;
      break;
    case kDeviceName:
      std::memcpy(&request[1], kName, sizeof kName);
      request[7] = plugged ? static_cast<std::int32_t>(std::strlen(kName)) : -1;
      break;
    default:
      break;
  }
  send(client.fd, request.data(), sizeof request, MSG_NOSIGNAL);
}

Spnav spnav;

int Read(int fd, SpnavEvent* event, int flags) {
  Packet packet{};
  if (recv(fd, packet.data(), sizeof packet, flags) != sizeof packet) return 0;
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
  spnav.clients.push_back({pair[1], kProtocol, kDefaultMask});
  spnav.StartPump();
  return 0;
}

FAKE_EXPORT int spnav_close() {
  const Guard guard(spnav.mutex);
  spnav.Enter(__func__);
  if (spnav.own < 0) return -1;
  close(spnav.own);
  spnav.own = -1;
  return 0;
}

FAKE_EXPORT int spnav_fd() {
  const Guard guard(spnav.mutex);
  return spnav.own;
}

#ifndef FAKE_MISSING
// 0 also where the daemon has gone: no event tells.
FAKE_EXPORT int spnav_poll_event(SpnavEvent* event) {
  const Guard guard(spnav.mutex);
  if (spnav.Enter(__func__) || spnav.own < 0) return 0;
  return Read(spnav.own, event, MSG_DONTWAIT);
}
#endif

FAKE_EXPORT int spnav_wait_event(SpnavEvent* event) {
  std::unique_lock lock(spnav.mutex);
  if (spnav.Enter(__func__)) return 0;
  const int fd = spnav.own;
  lock.unlock();
  return Read(fd, event, 0);
}

FAKE_EXPORT int spnav_remove_events(int) {
  const Guard guard(spnav.mutex);
  spnav.Enter(__func__);
  int count = 0;
  for (SpnavEvent event{}; spnav.own >= 0 && Read(spnav.own, &event, MSG_DONTWAIT) > 0;) ++count;
  return count;
}

FAKE_EXPORT int spnav_sensitivity(double) {
  const Guard guard(spnav.mutex);
  const int code = spnav.Enter(__func__);
  return code ? code : spnav.own < 0 ? -1 : 0;
}

FAKE_EXPORT int spnav_protocol() {
  const Guard guard(spnav.mutex);
  return spnav.own < 0 ? -1 : kProtocol;
}

FAKE_EXPORT int spnav_evmask(unsigned mask) {
  const Guard guard(spnav.mutex);
  if (spnav.Enter(__func__) || spnav.own < 0) return -1;
  for (auto& client : spnav.clients) client.mask = mask;
  return 0;
}

FAKE_EXPORT int spnav_client_name(const char*) {
  const Guard guard(spnav.mutex);
  return spnav.Enter(__func__);
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

FAKE_EXPORT int spnav_dev_buttons() {
  const Guard guard(spnav.mutex);
  return spnav.own < 0 || !spnav.plugged ? -1 : 15;
}

}  // namespace palpate::fakes
