// The device behind the fake of DHD.
#pragma once

#include <algorithm>
#include <cmath>

#include "tests/master/device/fakes/fake_core.h"

namespace palpate::fakes {
using Eigen::Vector3d;
using Guard = std::lock_guard<std::recursive_mutex>;

constexpr int kFailed = -1, kTimeGuard = 1, kSaturated = 2;
// Values of dhdErrorGetLast.
constexpr int kNoError = 0, kAnyError = 1, kComError = 2, kNoDevice = 5, kNotAvailable = 6,
              kNoExpert = 9, kNotReady = 12, kInvalidIndex = 15, kNotEnabled = 19, kInvalid = 21;
// Causes of forces that are off.
constexpr int kByButton = 1, kByVelocity = 2, kByWatchdog = 3, kBySoftware = 4, kByUsb = 5,
              kByDeadman = 6;
// Electromagnetic brakes, by which motors that are off slow the handle [N s/m].
constexpr double kBrake = 20;
constexpr double kGravity = 9.81;  // [m/s^2]

struct Model {
  const char *option, *name;
  int type;
  double max_force, mass;  // [N], [kg]
  bool wrist, gripper;
};
constexpr Model kModels[] = {{"omega.3", "omega.3", 33, 12, 0.22, false, false},
                             {"sigma.7", "sigma.7 right", 104, 20, 0.38, true, true},
                             {"falcon", "Falcon", 60, 8, 0.15, false, false}};

// Positions read that are kept for the velocity: at 1 kHz more than a second.
constexpr std::ptrdiff_t kMaxFixes = 4096;

struct Dhd : Core {
  struct Fix {
    double t;
    Vector3d p;
  };
  bool open = false, lost = false, force_on = false, brakes = false, expert = false, gravity = true;
  int cause = 0, last_error = kNoError, velocity_mode = 0;

  double window = 0.020, time_guard = 0.001, effector = 0, limit = 0, threshold = 0;
  double read_at = 0, force_at = 0;
  Sample read;
  std::vector<Fix> fixes;
  Vector3d motors = Vector3d::Zero();

  // model: omega.3, sigma.7 or falcon. watchdog: forces end that long after the last command [s].
  // tool: part of the mass that is screwed on [kg]. velocity_threshold: of the controller [m/s].
  // gripper: its angle [rad]. force_button and deadman: 1 while the force button is pressed, which
  // turns forces off; 0 while the hand has left a sigma's handle. transfer: time that each call
  // takes [s].
  std::map<std::string, std::string> Defaults() const override {
    return {{"model", "omega.3"},      {"watchdog", "0.1"},   {"velocity_threshold", "2"},
            {"gripper", "0.2"},        {"force_button", "0"}, {"deadman", "1"},
            {"serial", "1234"},        {"transfer", "0"},     {"tool", "0"},
            {"mass", "0.22"},          {"viscosity", "0.5"},  {"dry", "0.05"},
            {"resolution", "0.00001"}, {"half_x", "0.055"},   {"half_y", "0.08"},
            {"half_z", "0.08"},        {"force_gain", "1"}};
  }
  const Model& model() const { return *Found(); }
  const Model* Found() const {
    return std::find_if(std::begin(kModels), std::end(kModels),
                        [this](const Model& one) { return Text("model") == one.option; });
  }
  void OnReset() override {
    const Guard guard(mutex);
    open = lost = force_on = brakes = expert = false;
    Restart();
    last_error = kNoError;
  }
  // The device's state after it is opened.
  void Restart() {
    force_on = brakes = false;
    gravity = true;
    cause = 0;
    velocity_mode = 0;
    window = 0.020;
    time_guard = 0.001;
    effector = 0;
    limit = HUGE_VAL;
    threshold = Number("velocity_threshold");
    read_at = -1;
    fixes.clear();
    fixes.reserve(kMaxFixes);
    read = {};
    motors.setZero();
  }
  bool OnOption(const std::string& name) override {
    if (Found() == std::end(kModels)) return false;
    if (name == "model") SetOption("mass", std::to_string(model().mass));
    if (name == "force_button" && Number(name) != 0) TurnOff(kByButton);
    if (name == "deadman" && Number(name) == 0) TurnOff(kByDeadman);
    if (name == "velocity_threshold") threshold = Number(name);
    return true;
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
  double Brake() const override { return !MotorsOn() || brakes ? kBrake : 0; }
  // Weight that compensation does not carry: without power to the motors all of it, else that of
  // the tool beyond what dhdSetEffectorMass said.
  Vector3d Weight() const override {
    const bool carried = MotorsOn() && gravity;
    return Vector3d(0, 0, -kGravity * (carried ? Number("tool") - effector : Number("mass")));
  }
  // The controller's own guards. A frozen one guards nothing.
  void OnStep(double) override {
    if (!MotorsOn() || frozen) return;
    if (threshold > 0 && v.norm() > threshold) TurnOff(kByVelocity);
    if (time - force_at > Number("watchdog")) TurnOff(kByWatchdog);
  }

  int Fail(int error) {
    last_error = error;
    return kFailed;
  }
  // Enters the vendor's `function` on the device `id`: 0, or what it shall return.
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
    if (frozen || (read_at >= 0 && time - read_at < time_guard - 1e-9)) return kTimeGuard;
    read = Look();
    read_at = time;
    fixes.push_back({time, read.p});
    if (fixes.size() == kMaxFixes) fixes.erase(fixes.begin(), fixes.begin() + kMaxFixes / 2);
    return 0;
  }
  // Difference over the window of what was read: it is late by half of the window.
  Vector3d Velocity() const {
    if (fixes.size() < 2) return Vector3d::Zero();
    auto from = fixes.end() - 2;
    while (velocity_mode == 0 && from != fixes.begin() &&
           fixes.back().t - (from - 1)->t <= window + 1e-9)
      --from;
    return (fixes.back().p - from->p) / (fixes.back().t - from->t);
  }

  int Force(const Vector3d& f, const Vector3d& t, double grip) {
    if (!f.allFinite() || !t.allFinite() || !std::isfinite(grip)) return Fail(kInvalid);
    if (frozen) return 0;
    force_at = time;
    const double most = std::min(limit, model().max_force);
    const bool saturated = f.norm() > most;
    if (force_on) motors = Number("force_gain") * (saturated ? Vector3d(f * (most / f.norm())) : f);
    const Vector3d torque = model().wrist ? t : Vector3d(Vector3d::Zero());
    Log({f.x(), f.y(), f.z(), torque.x(), torque.y(), torque.z(), model().gripper ? grip : 0});
    return saturated ? kSaturated : 0;
  }
};

}  // namespace palpate::fakes
