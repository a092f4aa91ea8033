// The device behind the fake of DHD.
#pragma once

#include <algorithm>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {
using Eigen::Vector3d;
using Guard = std::lock_guard<std::recursive_mutex>;

constexpr int kFailed = -1, kTimeGuard = 1, kSaturated = 2;
// Values of dhdErrorGetLast.
constexpr int kNoError = 0, kAnyError = 1, kComError = 2, kNoDevice = 5, kNotAvailable = 6,
              kNotReady = 12, kInvalidIndex = 15, kNotEnabled = 19, kInvalid = 21;
// Causes of forces that are off.
constexpr int kByWatchdog = 3, kBySoftware = 4, kByUsb = 5, kByDeadman = 6;
constexpr double kTimeGuardLength = 0.001;  // a read within it repeats the last one [s]
struct Model {
  const char *option, *name;
  double max_force;  // [N]
  bool wrist, gripper;
};
constexpr Model kModels[] = {{"omega.3", "omega.3", 12, false, false},
                             {"sigma.7", "sigma.7 right", 20, true, true}};

// Number of positions kept to compute the velocity: more than a second at 1 kHz.
constexpr std::ptrdiff_t kMaxFixes = 4096;

struct Dhd : Core {
  struct Fix {
    double t;
    Vector3d p;
  };
  bool open = false, lost = false, force_on = false;
  int cause = 0, last_error = kNoError;
  double read_at = 0, force_at = 0;
  Sample read;
  std::vector<Fix> fixes;
  Vector3d motors = Vector3d::Zero();

  // model: omega.3 or sigma.7. watchdog: time after the last command at which forces end [s].
  // gripper: its angle [rad]. deadman: 0 while the operator does not hold the handle of a sigma.
  // transfer: duration of each call [s].
  std::map<std::string, std::string> Defaults() const override {
    return {{"model", "omega.3"}, {"watchdog", "0.1"}, {"gripper", "0.2"},       {"deadman", "1"},
            {"serial", "1234"},   {"transfer", "0"},   {"resolution", "0.00001"}};
  }
  const Model& model() const { return *Found(); }
  const Model* Found() const {
    return std::find_if(std::begin(kModels), std::end(kModels),
                        [this](const Model& one) { return Text("model") == one.option; });
  }
  void OnReset() override {
    const Guard guard(mutex);
    open = lost = false;
    Restart();
    last_error = kNoError;
  }
  // The device's state after it is opened.
  void Restart() {
    force_on = false;
    cause = 0;
    read_at = -1;
    fixes.clear();
    fixes.reserve(kMaxFixes);
    read = {};
    motors.setZero();
  }
  void OnOption(const std::string& name) override {
    if (name == "deadman" && Number(name) == 0) TurnOff(kByDeadman);
  }
  void OnPlug() override {
    if (plugged) return;
    lost = open;
    TurnOff(kByUsb);
  }
  void TurnOff(int why) {
    if (force_on) cause = why;
    force_on = false;
    motors.setZero();
  }

  bool MotorsOn() const override { return open && force_on && plugged; }
  Vector3d MotorForce() const override { return MotorsOn() ? motors : Vector3d(Vector3d::Zero()); }
  // The watchdog of the device's controller; it does not work in a frozen device.
  void OnStep(double) override {
    if (!MotorsOn() || frozen) return;
    if (time - force_at > Number("watchdog")) TurnOff(kByWatchdog);
  }

  int Fail(int error) {
    last_error = error;
    return kFailed;
  }
  // Begins a call of the vendor's `function` on device `id`. Returns 0, or the code that the
  // function must return.
  int Begin(const char* function, int id) {
    const int code = Enter(function);
    if (code < 0) return Fail(kAnyError), code;
    if (code > 0) return code;
    if (id != 0 && id != -1) return Fail(kInvalidIndex);
    if (!open) return Fail(kNotReady);
    if (lost || !plugged) return Fail(kComError);
    return 0;
  }
  // Reads the device, at most once in the time guard.
  int Read() {
    if (frozen || (read_at >= 0 && time - read_at < kTimeGuardLength - 1e-9)) return kTimeGuard;
    read = Look();
    read_at = time;
    fixes.push_back({time, read.p});
    if (fixes.size() == kMaxFixes) fixes.erase(fixes.begin(), fixes.begin() + kMaxFixes / 2);
    return 0;
  }
  // Returns the difference of read positions over 20 ms, which lags by 10 ms.
  Vector3d Velocity() const {
    if (fixes.size() < 2) return Vector3d::Zero();
    auto from = fixes.end() - 2;
    while (from != fixes.begin() && fixes.back().t - (from - 1)->t <= 0.020 + 1e-9) --from;
    return (fixes.back().p - from->p) / (fixes.back().t - from->t);
  }

  int Force(const Vector3d& f, const Vector3d& t) {
    if (!f.allFinite() || !t.allFinite()) return Fail(kInvalid);
    if (frozen) return 0;
    force_at = time;
    const double most = model().max_force;
    const bool saturated = f.norm() > most;
    if (force_on) motors = saturated ? Vector3d(f * (most / f.norm())) : f;
    Took(f);
    return saturated ? kSaturated : 0;
  }
};

}  // namespace palpate::fakes
