// The device and the scheduler behind the fake of HDAPI.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstring>
#include <limits>
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
                   kInvalidType = 0x103, kBadHandle = 0x104, kWarmMotors = 0x200,
                   kTooMuchForce = 0x201, kTooFast = 0x203, kForceError = 0x204,
                   kDeviceFault = 0x300, kAlreadyInitiated = 0x301, kCommError = 0x302,
                   kIllegalBegin = 0x400, kIllegalEnd = 0x401, kFrameError = 0x402;
constexpr unsigned kForceOutput = 0x4000, kClamping = 0x4001, kRamping = 0x4002,
                   kForceLimit = 0x4003;
constexpr unsigned kCalibrationOk = 0x5000, kNeedsUpdate = 0x5001, kNeedsManual = 0x5002;
constexpr unsigned kSchedulerFull = 0x501;
constexpr std::size_t kMaxErrors = 64, kMaxCallbacks = 16;
// An encoder count that was lost: where an uncalibrated device believes its handle to be [m].
const Vector3d kUncalibrated(0.025, -0.015, 0.040);

// Below this part of the limit motors that were warm make forces again.
constexpr double kCooled = 0.8;

enum Type : unsigned { kBoolean = 1, kInteger = 2, kFloat = 4, kDouble = 8, kLong = 16 };
constexpr unsigned kReal = kFloat | kDouble;

// What the device's model says.
struct Model {
  const char *option, *name;
  double max_force, continuous, stiffness;  // [N], [N], [N/mm]
  int output_dof;
};
constexpr Model kModels[] = {{"touch", "Touch", 3.3, 0.88, 0.5, 3},
                             {"touch-x", "Touch X", 7.9, 1.75, 1.0, 3},
                             {"premium-6dof", "PHANTOM Premium 1.5 6DOF", 8.5, 1.4, 0.8, 6}};

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
    unsigned short priority;
  };
  // Guards the list of callbacks; held while they run, so that who removes one waits until it is
  // out.
  std::recursive_mutex running;
  std::condition_variable_any done;
  std::vector<Scheduled> scheduled;  // by priority
  unsigned long last_id = 0;
  std::thread servo;
  std::atomic<bool> started = false;
  std::atomic<unsigned long> rate = 1000;
  double next_tick = 0, tick_at = 0;

  Handle initiated = kInvalidHandle, current = kInvalidHandle;
  bool lost = false;  // unplugged since it was initiated
  int inits = 0;
  Capabilities enabled;
  std::vector<ErrorInfo> errors;
  bool in_frame = false;
  Sample frame;
  Vector3d asked = Vector3d::Zero(), torque = Vector3d::Zero(), motors = Vector3d::Zero();
  bool hot = false;
  double enabled_since = 0, heat = 0, velocity_limit = 0, ramp_rate = 0;

  ~Hd() override { StopServo(); }

  // model: touch, touch-x or premium-6dof. name: what hdInitDevice accepts besides NULL; null: 0
  // refuses NULL. init_failures: how many calls of hdInitDevice fail at first. handle: what it
  // returns; one above 1024 is garbage. calibration: ok, update or manual, which the inkwell cures
  // while parked is 1. style: of calibration, 1 encoder reset, 2 automatic, 4 inkwell. heating:
  // seconds until the motors' temperature has followed (|f| / continuous)^2 to 63 %; at 1 they are
  // warm. velocity_limit [m/s]. ramp [N/s].
  std::map<std::string, std::string> Defaults() const override {
    return {{"model", "touch"}, {"name", "Default Device"},
            {"null", "1"},      {"init_failures", "0"},
            {"handle", "0"},    {"calibration", "ok"},
            {"parked", "0"},    {"style", "4"},
            {"heating", "60"},  {"velocity_limit", "2"},
            {"ramp", "100"},    {"serial", "012345678"},
            {"mass", "0.045"},  {"viscosity", "0.3"},
            {"dry", "0.1"},     {"resolution", "0.000055"},
            {"half_x", "0.08"}, {"half_y", "0.06"},
            {"half_z", "0.035"}};
  }
  const Model& model() const { return *Found(); }
  const Model* Found() const {
    return std::find_if(std::begin(kModels), std::end(kModels),
                        [this](const Model& one) { return Text("model") == one.option; });
  }

  void OnReset() override {
    StopServo();
    const Guard lists(running);
    const Guard guard(mutex);
    scheduled.clear();
    scheduled.reserve(kMaxCallbacks);
    rate = 1000;
    initiated = current = kInvalidHandle;
    lost = in_frame = false;
    inits = 0;
    enabled.clear();
    errors.clear();
    errors.reserve(kMaxErrors);
    frame = {};
    asked = torque = motors = Vector3d::Zero();
    heat = 0;
    hot = false;
  }
  bool OnOption(const std::string&) override { return Found() != std::end(kModels); }
  void OnPlug() override { lost = lost || !plugged; }

  bool MotorsOn() const override {
    return started && plugged && !lost && initiated != kInvalidHandle &&
           enabled.contains(kForceOutput) && !hot;
  }
  Vector3d MotorForce() const override {
    if (!MotorsOn()) return Vector3d::Zero();
    const double most = enabled.contains(kRamping) ? ramp_rate * (time - enabled_since)
                                                   : std::numeric_limits<double>::infinity();
    return motors.norm() > most ? Vector3d(motors * (most / motors.norm())) : motors;
  }
  void OnStep(double h) override {
    const double load = MotorForce().squaredNorm() / std::pow(model().continuous, 2);
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

  // What hdGet*v gives for `name`: `types` that it may be read as, and `count` numbers.
  struct Values {
    unsigned types = kReal;
    std::array<double, 16> all{};
    std::ptrdiff_t count = 0;
  };
  Values Find(unsigned name) const;
  template <class T>
  void Get(unsigned name, T* values, Type type, const char* function) {
    const Guard guard(mutex);
    if (!Begins(function) || !HasDevice()) return;
    const Values got = Find(name);
    if (got.count == 0) return Push(kInvalidEnum);
    if (!(got.types & type)) return Push(kInvalidType);
    std::transform(got.all.begin(), got.all.begin() + got.count, values,
                   [](double x) { return static_cast<T>(x); });
  }
  template <class T>
  void Set(unsigned name, const T* values, Type type, const char* function);

  void Tick();
  void RunServo();
  void StopServo();
  void StepTo(double t) override;
  void RunCallbacks();
  bool IsScheduled(unsigned long id) const;
  unsigned long Add(Callback call, void* data, unsigned short priority);
};

}  // namespace palpate::fakes
