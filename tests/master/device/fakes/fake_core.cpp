#include "tests/master/device/fakes/fake_core.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>

namespace palpate::fakes {
namespace {

using Eigen::Vector3d;
using Lock = std::lock_guard<std::recursive_mutex>;

// Largest time step of the simulated device [s].
constexpr double kStep = 0.00025;

double RealNow() {
  static const auto start = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

bool ReadNumber(const std::string& text, double& number) {
  char* end = nullptr;
  number = std::strtod(text.c_str(), &end);
  return !text.empty() && *end == 0 && !std::isnan(number);
}

}  // namespace

void Core::Reset() {
  {
    const Lock lock(mutex);
    manual_ = false;
    plugged = true;
    frozen = 0;
    time = RealNow();
    p.setZero();
    v.setZero();
    knots.clear();
    button_events.clear();
    buttons = 0;
    faults.clear();
    calls.clear();
    command.setZero();
    command_at = 0;
    shown_ = {};
    options_.clear();
    std::map<std::string, std::string> defaults = {{"resolution", "0"}};
    for (const auto& [name, text] : Defaults()) defaults[name] = text;
    for (const auto& [name, text] : defaults) {
      Option& option = options_[name];
      option.text = text;
      option.numeric = ReadNumber(text, option.number);
    }
  }
  OnReset();
}

void Core::SetClock(double now) {
  const Lock lock(mutex);
  followed_since += now - time;
  for (ButtonEvent& event : button_events) event.at += now - time;
  manual_now_ = time = now;
  manual_ = true;
}

void Core::Step(double seconds) {
  if (manual_) StepTo(manual_now_ + seconds);
}

void Core::StepTo(double t) {
  const Lock lock(mutex);
  manual_now_ = t;
  Advance(t);
}

double Core::Sync() {
  Advance(manual_ ? manual_now_.load() : RealNow());
  return time;
}

bool Core::SetOption(const std::string& name, const std::string& value) {
  const Lock lock(mutex);
  const auto found = options_.find(name);
  double number = 0;
  if (found == options_.end() || (found->second.numeric && !ReadNumber(value, number)))
    return false;
  Sync();
  found->second = {value, number, found->second.numeric};
  OnOption(name);
  return true;
}

void Core::Plug(bool in) {
  const Lock lock(mutex);
  Sync();
  Look();
  plugged = in;
  frozen = 0;
  OnPlug();
}

double Core::Number(std::string_view name) const {
  return options_.find(name)->second.number;
}

const std::string& Core::Text(std::string_view name) const {
  return options_.find(name)->second.text;
}

int Core::Enter(const char* function) {
  Sync();
  auto count = calls.find(function);
  if (count == calls.end()) count = calls.emplace(function, 0).first;
  ++count->second;
  for (const char* name : {function, ""}) {
    const auto fault = faults.find(name);
    if (fault == faults.end() || fault->second.count == 0) continue;
    if (fault->second.count > 0) --fault->second.count;
    return fault->second.code;
  }
  return 0;
}

const Sample& Core::Look() {
  if (frozen || !plugged) return shown_;
  const double step = Number("resolution");
  const auto rounded = [step](double x) { return step > 0 ? step * std::round(x / step) : x; };
  shown_ = {time, p.unaryExpr(rounded), v, buttons};
  return shown_;
}

void Core::Took(const Vector3d& force) {
  command = force;
  command_at = time;
}

// The handle moves with minimum jerk between the knots and rests at each knot. Without knots it
// rests.
void Core::FollowKnots() {
  v.setZero();
  if (knots.empty()) return;
  const double t = time - followed_since;
  const auto next = std::partition_point(knots.begin(), knots.end(),
                                         [t](const FakeKnot& knot) { return knot.t <= t; });
  const auto position = [](const FakeKnot& knot) { return Vector3d(knot.x, knot.y, knot.z); };
  if (next == knots.begin() || next == knots.end()) {
    p = position(next == knots.end() ? knots.back() : knots.front());
    return;
  }
  const FakeKnot& from = *(next - 1);
  const double span = next->t - from.t;
  const double s = (t - from.t) / span;
  const Vector3d way = position(*next) - position(from);
  p = position(from) + way * (s * s * s * (10 - 15 * s + 6 * s * s));
  v = way * (30 * s * s * (1 - s) * (1 - s) / span);
}

void Core::Advance(double until) {
  while (time < until) {
    const double h = std::min(kStep, until - time);
    FollowKnots();
    time = until - time > kStep ? time + h : until;
    for (const ButtonEvent& event : button_events) {
      if (event.at > time) continue;
      buttons = event.down ? buttons | 1u << event.button : buttons & ~(1u << event.button);
    }
    std::erase_if(button_events, [this](const ButtonEvent& event) { return event.at <= time; });
    OnStep(h);
  }
}

}  // namespace palpate::fakes

using palpate::fakes::Core;
using palpate::fakes::TheCore;
using Guard = std::lock_guard<std::recursive_mutex>;

FAKE_EXPORT void fake_reset() {
  TheCore().Reset();
}
FAKE_EXPORT void fake_set_clock(double now) {
  TheCore().SetClock(now);
}
FAKE_EXPORT void fake_step(double seconds) {
  TheCore().Step(seconds);
}

FAKE_EXPORT double fake_now() {
  const Guard guard(TheCore().mutex);
  return TheCore().Sync();
}

FAKE_EXPORT int fake_set_option(const char* name, const char* value) {
  return TheCore().SetOption(name, value) ? 0 : -1;
}

FAKE_EXPORT void fake_place(double x, double y, double z) {
  const Guard guard(TheCore().mutex);
  TheCore().Sync();
  TheCore().p = {x, y, z};
  TheCore().v.setZero();
}

FAKE_EXPORT void fake_follow(const FakeKnot* knots, int count) {
  const Guard guard(TheCore().mutex);
  TheCore().followed_since = TheCore().Sync();
  TheCore().knots.assign(knots, knots + count);
}

FAKE_EXPORT void fake_press(int button, int down, double after) {
  if (button < 0 || button > 31) return;
  const Guard guard(TheCore().mutex);
  TheCore().button_events.push_back({TheCore().Sync() + after, button, down != 0});
}

FAKE_EXPORT void fake_unplug() {
  TheCore().Plug(false);
}
FAKE_EXPORT void fake_replug() {
  TheCore().Plug(true);
}

FAKE_EXPORT void fake_freeze(int mode) {
  const Guard guard(TheCore().mutex);
  TheCore().Sync();
  TheCore().Look();
  TheCore().frozen = mode;
}

FAKE_EXPORT void fake_set_error(const char* function, int code, int count) {
  const Guard guard(TheCore().mutex);
  TheCore().faults[function] = {code, count};
}

FAKE_EXPORT int fake_last_force(double f[3]) {
  const Guard guard(TheCore().mutex);
  TheCore().Sync();
  Eigen::Map<Eigen::Vector3d>{f} = TheCore().MotorForce();
  return TheCore().MotorsOn();
}

FAKE_EXPORT double fake_last_command(double f[3]) {
  const Guard guard(TheCore().mutex);
  Eigen::Map<Eigen::Vector3d>{f} = TheCore().command;
  return TheCore().command_at;
}

FAKE_EXPORT int fake_calls(const char* function) {
  const Guard guard(TheCore().mutex);
  const auto found = TheCore().calls.find(function);
  return found == TheCore().calls.end() ? 0 : found->second;
}
