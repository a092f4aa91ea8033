// A fake of Force Dimension's DHD library with one device, whose identifier is 0 (-1 also means
// this device).
#include "tests/master/device/fakes/fake_dhd.h"

#include <chrono>
#include <thread>

namespace palpate::fakes {
namespace {

Dhd dhd;

void Put(const Vector3d& a, double* x, double* y, double* z) {
  *x = a.x();
  *y = a.y();
  *z = a.z();
}

}  // namespace

Core& TheCore() {
  return dhd;
}

namespace {
const Start start(dhd, "DHD");
}

// Waits for the duration of a USB transfer. With an injected clock it does not wait.
void Transfer() {
  const auto is_done = [begin = std::chrono::steady_clock::now()] {
    const Guard guard(dhd.mutex);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    return dhd.manual() || took.count() >= dhd.Number("transfer");
  };
  while (!is_done()) std::this_thread::sleep_for(std::chrono::microseconds(50));
}

// Runs a function of the vendor on an open device. A negative code of `Begin` is returned as the
// result.
template <class Work>
int On(const char* function, int id, Work work) {
  Transfer();
  const Guard guard(dhd.mutex);
  const int code = dhd.Begin(function, id);
  if (code < 0) return code;
  const int result = work();
  return code > 0 && result >= 0 ? code : result;
}

// Returns a property; false also after an error, as in DHD.
template <class What>
bool Is(const char* function, int id, What what) {
  const Guard guard(dhd.mutex);
  return dhd.Begin(function, id) == 0 && what();
}

FAKE_EXPORT int dhdGetDeviceCount() {
  const Guard guard(dhd.mutex);
  const int code = dhd.Enter(__func__);
  return code ? code : dhd.plugged;
}

FAKE_EXPORT int dhdOpen() {
  const Guard guard(dhd.mutex);
  if (dhd.Enter(__func__)) return dhd.Fail(kAnyError);
  if (!dhd.plugged) return dhd.Fail(kNoDevice);
  dhd.open = true;
  dhd.lost = false;
  dhd.Restart();
  return 0;
}

FAKE_EXPORT int dhdOpenSerial(int serial) {
  const Guard guard(dhd.mutex);
  const bool known = serial == static_cast<int>(dhd.Number("serial"));
  return dhd.Enter(__func__) || !known ? dhd.Fail(kNoDevice) : dhdOpen();
}

FAKE_EXPORT int dhdClose(char id) {
  const Guard guard(dhd.mutex);
  const int code = dhd.Begin(__func__, id);
  dhd.TurnOff(kBySoftware);
  dhd.open = false;
  return code;
}

FAKE_EXPORT int dhdStop(char id) {
  return On(__func__, id, [] { return dhd.TurnOff(kBySoftware), 0; });
}

FAKE_EXPORT const char* dhdGetSystemName(char id) {
  return Is(__func__, id, [] { return true; }) ? dhd.model().name : nullptr;
}

FAKE_EXPORT void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
  *major = 3, *minor = 17, *release = 5, *revision = 0;
}

FAKE_EXPORT int dhdErrorGetLast() {
  const Guard guard(dhd.mutex);
  return dhd.last_error;
}

FAKE_EXPORT const char* dhdErrorGetLastStr() {
  static const std::map<int, const char*> words = {
      {kNoError, "no error"},          {kComError, "communication error"},
      {kNoDevice, "no device found"},  {kNotAvailable, "feature not available"},
      {kNotReady, "device not ready"}, {kInvalidIndex, "invalid index"}};
  const auto found = words.find(dhdErrorGetLast());
  return found == words.end() ? "undefined error" : found->second;
}

FAKE_EXPORT bool dhdHasWrist(char id) {
  return Is(__func__, id, [] { return dhd.model().wrist; });
}
FAKE_EXPORT bool dhdHasActiveWrist(char id) {
  return Is(__func__, id, [] { return dhd.model().wrist; });
}
FAKE_EXPORT bool dhdHasGripper(char id) {
  return Is(__func__, id, [] { return dhd.model().gripper; });
}

// Enables forces, also after they were disabled, provided that the cause is gone.
FAKE_EXPORT int dhdEnableForce(unsigned char on, char id) {
  return On(__func__, id, [=] {
    if (!on) return dhd.TurnOff(kBySoftware), 0;
    if (dhd.Number("deadman") == 0) return dhd.Fail(kNotEnabled);
    dhd.force_on = true;
    dhd.cause = 0;
    dhd.force_at = dhd.time;
    return 0;
  });
}

FAKE_EXPORT int dhdGetPosition(double* x, double* y, double* z, char id) {
  return On(__func__, id, [=] {
    const int code = dhd.Read();
    Put(dhd.read.p, x, y, z);
    return code;
  });
}

FAKE_EXPORT int dhdGetOrientationFrame(double frame[3][3], char id) {
  return On(__func__, id, [=] {
    if (!dhd.model().wrist) return dhd.Fail(kNotAvailable);
    const int code = dhd.Read();
    // The handle is never rotated.
    for (int i = 0; i < 9; ++i) frame[i / 3][i % 3] = i % 4 == 0 ? 1 : 0;
    return code;
  });
}

FAKE_EXPORT int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  return On(__func__, id, [=] {
    const int code = dhd.Read();
    Put(dhd.Velocity(), x, y, z);
    return code;
  });
}

// The jaws are 60 mm long.
FAKE_EXPORT int dhdGetGripperGap(double* gap, char id) {
  return On(__func__, id, [=] {
    if (!dhd.model().gripper) return dhd.Fail(kNotAvailable);
    return *gap = 2 * 0.06 * std::sin(dhd.Number("gripper") / 2), 0;
  });
}

FAKE_EXPORT unsigned dhdGetButtonMask(char id) {
  return Is(__func__, id, [] { return true; }) ? dhd.Look().buttons & 0xFFFF : 0;
}

FAKE_EXPORT int dhdSetForce(double x, double y, double z, char id) {
  return On(__func__, id, [=] { return dhd.Force({x, y, z}, Vector3d::Zero()); });
}

FAKE_EXPORT int dhdGetForce(double* x, double* y, double* z, char id) {
  return On(__func__, id, [=] { return Put(dhd.motors, x, y, z), 0; });
}

FAKE_EXPORT int dhdSetForceAndTorque(double x, double y, double z, double tx, double ty, double tz,
                                     char id) {
  return On(__func__, id, [=] { return dhd.Force({x, y, z}, {tx, ty, tz}); });
}

FAKE_EXPORT double dhdGetMaxForce(char id) {
  const bool there = Is(__func__, id, [] { return true; });
  return there ? dhd.model().max_force : kFailed;
}

// An unplugged device has a status too, with the error.
FAKE_EXPORT int dhdGetStatus(int* status, char id) {
  const Guard guard(dhd.mutex);
  const int code = dhd.Begin(__func__, id);
  if (code < 0 && dhd.last_error != kComError) return code;
  const int wrist = dhd.model().wrist;
  const bool guarded = dhd.read_at >= 0 && dhd.time - dhd.read_at < kTimeGuardLength;
  const int all[17] = {dhd.plugged,
                       dhd.plugged && !dhd.lost,
                       dhd.open,
                       1,
                       !dhd.force_on,
                       dhd.force_on,
                       !dhd.force_on,
                       wrist,
                       wrist,
                       dhd.lost,
                       1,
                       guarded,
                       wrist,
                       0,
                       dhd.cause,
                       0,
                       7};
  std::copy(all, all + 17, status);
  return code;
}

}  // namespace palpate::fakes
