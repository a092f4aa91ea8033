// The device and the scheduler behind the fake of HDAPI.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <vector>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {

struct ErrorInfo {
  unsigned code;
  int internal;
  unsigned device;
};

using Eigen::Vector3d;
using Handle = unsigned;
using Callback = unsigned (*)(void*);
using Guard = std::lock_guard<std::recursive_mutex>;

constexpr Handle kInvalidHandle = 0xFFFFFFFF;
constexpr unsigned kInvalidEnum = 0x100, kInvalidValue = 0x101, kInvalidOperation = 0x102,
                   kBadHandle = 0x104, kWarmMotors = 0x200, kTooMuchForce = 0x201, kTooFast = 0x203,
                   kForceError = 0x204, kDeviceFault = 0x300, kAlreadyInitiated = 0x301,
                   kCommError = 0x302, kIllegalBegin = 0x400, kIllegalEnd = 0x401,
                   kFrameError = 0x402;
constexpr unsigned kForceOutput = 0x4000, kClamping = 0x4001, kRamping = 0x4002,
                   kForceLimit = 0x4003;
constexpr unsigned kCalibrationOk = 0x5000, kNeedsUpdate = 0x5001, kNeedsManual = 0x5002;
constexpr unsigned kSchedulerFull = 0x501;
constexpr std::size_t kMaxErrors = 64, kMaxCallbacks = 16;
// Offset of the reported position of an uncalibrated device [m].
const Vector3d kUncalibrated(0.025, -0.015, 0.040);

// A Touch.
constexpr double kMaxForce = 3.3, kContinuousForce = 0.88;  // [N]
constexpr double kVelocityLimit = 2, kRamp = 100;           // [m/s], [N/s]
constexpr std::chrono::milliseconds kTickPeriod(1);
// Below this part of the limit motors that were warm make forces again.
constexpr double kCooled = 0.8;

// Capabilities that are enabled.
class Capabilities {
 public:
  [[nodiscard]] bool contains(unsigned capability) const { return (bits_ & Bit(capability)) != 0; }
  void insert(unsigned capability) { bits_ |= Bit(capability); }
  void erase(unsigned capability) { bits_ &= ~Bit(capability); }
  void clear() { bits_ = 0; }

 private:
  static unsigned Bit(unsigned capability) { return 1U << (capability & 31U); }
  unsigned bits_ = 0;
};

struct Hd : Core {
  struct Scheduled {
    unsigned long id;
    Callback call;
    void* data;
  };
  // Guards the list of callbacks. It is locked while they run, so that removing a callback waits
  // for its end.
  std::recursive_mutex running;
  std::vector<Scheduled> scheduled;
  unsigned long last_id = 0;
  std::thread servo;
  std::atomic<bool> started = false;
  double next_tick = 0;

  Handle initiated = kInvalidHandle, current = kInvalidHandle;
  bool lost = false;  // unplugged since it was initiated
  Capabilities enabled;
  std::vector<ErrorInfo> errors;
  bool in_frame = false;
  Sample frame;
  Vector3d asked = Vector3d::Zero(), motors = Vector3d::Zero();
  bool hot = false;
  double enabled_since = 0, heat = 0;

  ~Hd() override { StopServo(); }

  // calibration: ok, update or manual; in the state manual, the device calibrates in its inkwell if
  // `parked` is 1. style: of calibration, 1 encoder reset, 2 automatic, 4 inkwell. heating: seconds
  // until the motors' temperature has followed (|f| / continuous)^2 to 63 %; at 1 they are warm.
  std::map<std::string, std::string> Defaults() const override {
    return {{"calibration", "ok"},
            {"parked", "0"},
            {"style", "4"},
            {"heating", "60"},
            {"resolution", "0.000055"}};
  }

  void OnReset() override {
    StopServo();
    const Guard lists(running);
    const Guard guard(mutex);
    scheduled.clear();
    scheduled.reserve(kMaxCallbacks);
    initiated = current = kInvalidHandle;
    lost = in_frame = false;
    enabled.clear();
    errors.clear();
    errors.reserve(kMaxErrors);
    frame = {};
    asked = motors = Vector3d::Zero();
    heat = 0;
    hot = false;
  }
  void OnPlug() override { lost = lost || !plugged; }

  bool MotorsOn() const override {
    return started && plugged && !lost && initiated != kInvalidHandle &&
           enabled.contains(kForceOutput) && !hot;
  }
  Vector3d MotorForce() const override {
    if (!MotorsOn()) return Vector3d::Zero();
    const double most = enabled.contains(kRamping) ? kRamp * (time - enabled_since) : HUGE_VAL;
    return motors.norm() > most ? Vector3d(motors * (most / motors.norm())) : motors;
  }
  void OnStep(double h) override {
    const double load = MotorForce().squaredNorm() / std::pow(kContinuousForce, 2);
    heat += (load - heat) * h / Number("heating");
    hot = heat >= (hot ? kCooled : 1);
  }

  void Push(unsigned code) {
    if (errors.size() < kMaxErrors) errors.push_back({code, 0, current});
  }
  // Enters the vendor's `function`; false: it fails, and the error is queued.
  bool Begins(const char* function) {
    const int code = Enter(function);
    if (code) Push(static_cast<unsigned>(code));
    return code == 0;
  }
  bool HasDevice() {
    if (current != kInvalidHandle && current == initiated) return true;
    Push(kBadHandle);
    return false;
  }
  unsigned Calibration() const {
    const std::string& state = Text("calibration");
    if (state == "ok") return kCalibrationOk;
    return state == "update" || Number("parked") != 0 ? kNeedsUpdate : kNeedsManual;
  }
  // The state of the device for the frame that begins.
  void Take() {
    frame = Look();
    if (Calibration() != kCalibrationOk) frame.p += kUncalibrated;
  }

  // The `count` numbers that hdGet*v returns for `name`.
  struct Values {
    std::array<double, 16> all{};
    std::ptrdiff_t count = 0;
  };
  Values Find(unsigned name) const;
  template <class T>
  void Get(unsigned name, T* values, const char* function) {
    const Guard guard(mutex);
    if (!Begins(function) || !HasDevice()) return;
    const Values got = Find(name);
    if (got.count == 0) return Push(kInvalidEnum);
    std::transform(got.all.begin(), got.all.begin() + got.count, values,
                   [](double x) { return static_cast<T>(x); });
  }
  void SetForce(unsigned name, const double* values, const char* function);

  void Tick();
  void RunServo();
  void StopServo();
  void StepTo(double t) override;
  void RunCallbacks();
  bool IsScheduled(unsigned long id) const;
  unsigned long Add(Callback call, void* data);
};

}  // namespace palpate::fakes
