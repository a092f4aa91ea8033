// `force_gain`: what the motors make of a commanded force.
// A stand-in for Force Dimension's DHD: one device with the identifier 0, which -1 means too.
//
// Compiled with FAKE_MISSING it lacks dhdGetStatus and dhdSetForce; with FAKE_OLD it is
// version 3.2.2: status of 13 numbers, without dhdGetPositionAndOrientationFrame,
// dhdSetForceAndTorqueAndGripperForce, dhdSetVibration, dhdSetMaxForce.
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

void Put(const Eigen::Matrix3d& R, double frame[3][3]) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) frame[i][j] = R(i, j);
  }
}

}  // namespace

Core& TheCore() {
  return dhd;
}

namespace {
const Start start(dhd, "DHD");
}

// Takes the time of a USB transfer. With an injected clock there is none.
void Transfer() {
  const auto is_done = [begin = std::chrono::steady_clock::now()] {
    const Guard guard(dhd.mutex);
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    return dhd.manual() || took.count() >= dhd.Number("transfer");
  };
  while (!is_done()) std::this_thread::sleep_for(std::chrono::microseconds(50));
}

// What the vendor's function does on an open device; negative codes of `Begin` end it.
template <class Work>
int On(const char* function, int id, Work work) {
  Transfer();
  const Guard guard(dhd.mutex);
  const int code = dhd.Begin(function, id);
  if (code < 0) return code;
  const int result = work();
  return code > 0 && result >= 0 ? code : result;
}

// A property, with which no error is told apart from "no".
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

FAKE_EXPORT int dhdOpenID(char id) {
  const Guard guard(dhd.mutex);
  if (dhd.Enter(__func__)) return dhd.Fail(kAnyError);
  if (!dhd.plugged) return dhd.Fail(kNoDevice);
  if (id != 0 && id != -1) return dhd.Fail(kInvalidIndex);
  dhd.open = true;
  dhd.lost = false;
  dhd.Restart();
  return 0;
}

FAKE_EXPORT int dhdOpen() {
  const Guard guard(dhd.mutex);
  return dhd.Enter(__func__) ? dhd.Fail(kAnyError) : dhdOpenID(0);
}

FAKE_EXPORT int dhdOpenSerial(int serial) {
  const Guard guard(dhd.mutex);
  const bool known = serial == static_cast<int>(dhd.Number("serial"));
  return dhd.Enter(__func__) || !known ? dhd.Fail(kNoDevice) : dhdOpenID(0);
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

FAKE_EXPORT int dhdGetSystemType(char id) {
  return On(__func__, id, [] { return dhd.model().type; });
}

FAKE_EXPORT int dhdGetSerialNumber(unsigned short* serial, char id) {
  return On(__func__, id,
            [=] { return *serial = static_cast<unsigned short>(dhd.Number("serial")), 0; });
}

FAKE_EXPORT void dhdGetSDKVersion(int* major, int* minor, int* release, int* revision) {
#ifdef FAKE_OLD
  *major = 3, *minor = 2, *release = 2, *revision = 1466;
#else
  *major = 3, *minor = 17, *release = 5, *revision = 0;
#endif
}

FAKE_EXPORT int dhdErrorGetLast() {
  const Guard guard(dhd.mutex);
  return dhd.last_error;
}

FAKE_EXPORT const char* dhdErrorGetLastStr() {
  static const std::map<int, const char*> words = {{kNoError, "no error"},
                                                   {kComError, "communication error"},
                                                   {kNoDevice, "no device found"},
                                                   {kNotAvailable, "feature not available"},
                                                   {kNoExpert, "expert mode disabled"},
                                                   {kNotReady, "device not ready"},
                                                   {kInvalidIndex, "invalid index"}};
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
FAKE_EXPORT bool dhdHasActiveGripper(char id) {
  return Is(__func__, id, [] { return dhd.model().gripper; });
}
FAKE_EXPORT bool dhdIsLeftHanded(char id) {
  return Is(__func__, id, [] { return false; });
}

FAKE_EXPORT int dhdEnableExpertMode() {
  const Guard guard(dhd.mutex);
  dhd.expert = true;
  return dhd.Enter(__func__);
}

FAKE_EXPORT int dhdDisableExpertMode() {
  const Guard guard(dhd.mutex);
  dhd.expert = false;
  return dhd.Enter(__func__);
}

FAKE_EXPORT int dhdSetTimeGuard(int us, char id) {
  return On(__func__, id,
            [=] { return dhd.expert ? dhd.time_guard = us * 1e-6, 0 : dhd.Fail(kNoExpert); });
}

FAKE_EXPORT int dhdSetVelocityThreshold(unsigned mm_per_s, char id) {
  return On(__func__, id,
            [=] { return dhd.expert ? dhd.threshold = mm_per_s * 1e-3, 0 : dhd.Fail(kNoExpert); });
}

// Forces begin here, also after any of the causes that ended them, while the cause itself is gone.
FAKE_EXPORT int dhdEnableForce(unsigned char on, char id) {
  return On(__func__, id, [=] {
    if (!on) return dhd.TurnOff(kBySoftware), 0;
    if (dhd.Number("force_button") != 0 || dhd.Number("deadman") == 0) return dhd.Fail(kNotEnabled);
    dhd.force_on = true;
    dhd.brakes = false;
    dhd.cause = 0;
    dhd.force_at = dhd.time;
    return 0;
  });
}

FAKE_EXPORT int dhdSetGravityCompensation(int on, char id) {
  return On(__func__, id, [=] { return dhd.gravity = on != 0, 0; });
}

FAKE_EXPORT int dhdSetEffectorMass(double kg, char id) {
  return On(__func__, id, [=] { return kg >= 0 ? dhd.effector = kg, 0 : dhd.Fail(kInvalid); });
}

FAKE_EXPORT int dhdSetBrakes(int on, char id) {
  return On(__func__, id, [=] { return dhd.brakes = on != 0, 0; });
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
    Put(dhd.read.R, frame);
    return code;
  });
}

#ifndef FAKE_OLD
FAKE_EXPORT int dhdGetPositionAndOrientationFrame(double* x, double* y, double* z,
                                                  double frame[3][3], char id) {
  return On(__func__, id, [=] {
    const int code = dhd.Read();
    Put(dhd.read.p, x, y, z);
    Put(dhd.model().wrist ? dhd.read.R : Eigen::Matrix3d::Identity(), frame);
    return code;
  });
}
#endif

FAKE_EXPORT int dhdConfigLinearVelocity(int ms, int mode, char id) {
  return On(__func__, id, [=] {
    if (ms <= 0 || (mode != 0 && mode != 2)) return dhd.Fail(kInvalid);
    dhd.window = ms * 1e-3;
    dhd.velocity_mode = mode;
    return 0;
  });
}

FAKE_EXPORT int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  return On(__func__, id, [=] {
    const int code = dhd.Read();
    Put(dhd.Velocity(), x, y, z);
    return code;
  });
}

FAKE_EXPORT int dhdGetAngularVelocityRad(double* x, double* y, double* z, char id) {
  return On(__func__, id, [=] {
    return dhd.model().wrist ? Put(Vector3d::Zero(), x, y, z), 0 : dhd.Fail(kNotAvailable);
  });
}

FAKE_EXPORT int dhdGetGripperAngleRad(double* angle, char id) {
  return On(__func__, id, [=] {
    return dhd.model().gripper ? *angle = dhd.Number("gripper"), 0 : dhd.Fail(kNotAvailable);
  });
}

// The jaws are 60 mm long.
FAKE_EXPORT int dhdGetGripperGap(double* gap, char id) {
  const int code = dhdGetGripperAngleRad(gap, id);
  if (code == 0) *gap = 2 * 0.06 * std::sin(*gap / 2);
  return code;
}

FAKE_EXPORT int dhdGetButton(int index, char id) {
  return On(__func__, id, [=] {
    return index < 0 || index > 15 ? dhd.Fail(kInvalidIndex)
                                   : static_cast<int>(dhd.Look().buttons >> index & 1);
  });
}

FAKE_EXPORT unsigned dhdGetButtonMask(char id) {
  return Is(__func__, id, [] { return true; }) ? dhd.Look().buttons & 0xFFFF : 0;
}

#ifndef FAKE_MISSING
FAKE_EXPORT int dhdSetForce(double x, double y, double z, char id) {
  return On(__func__, id, [=] { return dhd.Force({x, y, z}, Vector3d::Zero(), 0); });
}
#endif

FAKE_EXPORT int dhdGetForce(double* x, double* y, double* z, char id) {
  return On(__func__, id, [=] { return Put(dhd.motors, x, y, z), 0; });
}

FAKE_EXPORT int dhdSetForceAndTorque(double x, double y, double z, double tx, double ty, double tz,
                                     char id) {
  return On(__func__, id, [=] { return dhd.Force({x, y, z}, {tx, ty, tz}, 0); });
}

#ifndef FAKE_OLD
FAKE_EXPORT int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double tx,
                                                    double ty, double tz, double grip, char id) {
  return On(__func__, id, [=] { return dhd.Force({x, y, z}, {tx, ty, tz}, grip); });
}

FAKE_EXPORT int dhdSetVibration(double, double, int, char id) {
  return On(__func__, id, [] { return 0; });
}

FAKE_EXPORT int dhdSetMaxForce(double newtons, char id) {
  return On(__func__, id, [=] { return dhd.limit = newtons < 0 ? HUGE_VAL : newtons, 0; });
}
#endif

FAKE_EXPORT int dhdSetMaxTorque(double, char id) {
  return On(__func__, id, [] { return 0; });
}

FAKE_EXPORT double dhdGetMaxForce(char id) {
  const bool there = Is(__func__, id, [] { return true; });
  return there ? std::min(dhd.limit, dhd.model().max_force) : kFailed;
}

FAKE_EXPORT double dhdGetComFreq(char id) {
  if (!Is(__func__, id, [] { return dhd.fixes.size() > 1; })) return 0;
  const double span = dhd.fixes.back().t - dhd.fixes.front().t;
  return 1e-3 * static_cast<double>(dhd.fixes.size() - 1) / span;
}

// An unplugged device has a status too, with the error.
#ifndef FAKE_MISSING
FAKE_EXPORT int dhdGetStatus(int* status, char id) {
  const Guard guard(dhd.mutex);
  const int code = dhd.Begin(__func__, id);
  if (code < 0 && dhd.last_error != kComError) return code;
  const int wrist = dhd.model().wrist;
  const bool guarded = dhd.read_at >= 0 && dhd.time - dhd.read_at < dhd.time_guard;
  const int all[17] = {dhd.plugged,
                       dhd.plugged && !dhd.lost,
                       dhd.open,
                       1,
                       !dhd.force_on,
                       dhd.force_on,
                       dhd.brakes || !dhd.force_on,
                       wrist,
                       wrist,
                       dhd.lost,
                       dhd.gravity,
                       guarded,
                       wrist,
                       0,
                       dhd.cause,
                       0,
                       7};
#ifdef FAKE_OLD
  std::copy(all, all + 13, status);
#else
  std::copy(all, all + 17, status);
#endif
  return code;
}
#endif

FAKE_EXPORT void dhdEnableSimulator(bool) {
  const Guard guard(dhd.mutex);
  dhd.Enter(__func__);
}

}  // namespace palpate::fakes
