// A stand-in for OpenHaptics HDAPI: one device, own servo thread, errors in a queue.
//
// Compiled with FAKE_MISSING it lacks hdGetError and hdScheduleAsynchronous; with FAKE_OLD it is
// version 1.0: without hdSetSchedulerRate, and without motor temperature and nominal damping.
#include "tests/master/device/fakes/fake_hd.h"

namespace palpate::fakes {

Hd::Values Hd::Find(unsigned name) const {
  const auto numbers = [](std::initializer_list<double> all, unsigned types = kReal) {
    Values values{types, {}, static_cast<std::ptrdiff_t>(all.size())};
    std::copy(all.begin(), all.end(), values.all.begin());
    return values;
  };
  const auto list = [&](const Vector3d& a) { return numbers({a.x(), a.y(), a.z()}); };
  const auto whole = [&](double a, unsigned types = kInteger) { return numbers({a}, types); };
  if (name == 0x2000) return whole(frame.buttons);
  if (name == 0x2001) return whole(1, kBoolean | kInteger);
  if (name == 0x2002) return whole(Number("parked") == 0, kBoolean | kInteger);
  if (name == 0x2050) return list(1000 * frame.p);
  if (name == 0x2051) return list(1000 * frame.v);
  if (name == 0x2052) {
    Values values{kReal, {}, 16};
    Eigen::Map<Eigen::Matrix4d> transform(values.all.data());  // columns one after another
    transform.setIdentity();
    transform.topLeftCorner<3, 3>() = frame.R;
    transform.topRightCorner<3, 1>() = 1000 * frame.p;
    return values;
  }
  if (name == 0x2053) return numbers({0, 0, 0});
  if (name == 0x2100)
    return numbers({std::atan2(frame.p.x(), 0.2), frame.p.y() / 0.3, frame.p.z() / 0.3});
  if (name == 0x2150) return list(frame.R.eulerAngles(2, 1, 0));
  if (name == 0x2550 || name == 0x2551) {
    const Vector3d half(Number("half_x"), Number("half_y"), Number("half_z"));
    const Vector3d most = (name == 0x2550 ? 1200 : 1000) * half;
    return numbers({-most.x(), -most.y(), -most.z(), most.x(), most.y(), most.z()});
  }
  if (name == 0x2552) return numbers({-110});
  if (name == 0x2553) return whole(6);
  if (name == 0x2554) return whole(model().output_dof);
  if (name == 0x2555) return whole(Number("style"));
  if (name == 0x2600 || name == 0x2601) return whole(static_cast<double>(rate.load()));
  if (name == 0x2602) return numbers({model().stiffness});
  if (name == 0x2603) return numbers({model().max_force});
  if (name == 0x2604) return numbers({model().continuous});
#ifndef FAKE_OLD
  if (name == 0x2605) return numbers({heat, heat, heat, heat, heat, heat});
  if (name == 0x2609) return numbers({0.003});
#endif
  if (name == 0x2606) return numbers({1000 * velocity_limit});
  if (name == 0x2608) return numbers({ramp_rate});
  if (name == 0x2700) return list(asked);
  if (name == 0x2701 || name == 0x2704) return list(torque);
  return {};
}

template <class T>
void Hd::Set(unsigned name, const T* values, Type type, const char* function) {
  const Guard guard(mutex);
  if (!Begins(function) || !HasDevice()) return;
  const bool force = name == 0x2700, gimbal = name == 0x2701 || name == 0x2704;
  if (!force && !gimbal && name != 0x2606 && name != 0x2608) return Push(kInvalidEnum);
  if (!(type & kReal)) return Push(kInvalidType);
  const auto at = [values](int i) { return static_cast<double>(values[i]); };
  if (name == 0x2606 || name == 0x2608) {
    if (!(at(0) > 0)) return Push(kInvalidValue);
    (name == 0x2606 ? velocity_limit : ramp_rate) = name == 0x2606 ? at(0) / 1000 : at(0);
    return;
  }
  if (!in_frame) return Push(kFrameError);
  if (gimbal && model().output_dof < 6) return Push(kInvalidOperation);
  (force ? asked : torque) = Vector3d(at(0), at(1), at(2));
}

bool Hd::IsScheduled(unsigned long id) const {
  return std::any_of(scheduled.begin(), scheduled.end(), [id](auto& one) { return one.id == id; });
}

// `running` is locked.
unsigned long Hd::Add(Callback call, void* data, unsigned short priority) {
  if (scheduled.size() == kMaxCallbacks) {
    const Guard guard(mutex);
    Push(kSchedulerFull);
    return 0;
  }
  const auto lower = [priority](const Scheduled& one) { return one.priority < priority; };
  scheduled.insert(std::find_if(scheduled.begin(), scheduled.end(), lower),
                   {++last_id, call, data, priority});
  return last_id;
}

// Callbacks may schedule and remove callbacks; those that are new run in the next tick.
void Hd::RunCallbacks() {
  const Guard lists(running);
  std::array<Scheduled, kMaxCallbacks> now;
  const auto end = std::copy(scheduled.begin(), scheduled.end(), now.begin());
  std::for_each(now.begin(), end, [this](const Scheduled& one) {
    if (!IsScheduled(one.id) || one.call(one.data) != 0) return;
    std::erase_if(scheduled, [&one](const Scheduled& other) { return other.id == one.id; });
  });
  done.notify_all();
}

void Hd::Tick() {
  bool runs = false;
  {
    const Guard guard(mutex);
    tick_at = Sync();
    runs = started && frozen != 2;
  }
  if (runs) RunCallbacks();
}

// The vendor's thread has a high priority; without permission it stays ordinary.
void Hd::RunServo() {
  const sched_param high{80};
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &high);
  auto wake = std::chrono::steady_clock::now();
  while (started && !manual()) {
    Tick();
    const std::chrono::microseconds period(1000000 / rate);
    wake += period;
    const auto now = std::chrono::steady_clock::now();
    while (wake < now) wake += period;
    std::this_thread::sleep_until(wake);
  }
}

void Hd::StopServo() {
  started = false;
  if (servo.joinable()) servo.join();
}

// A tick at each period of the injected clock.
void Hd::StepTo(double t) {
  const double period = 1.0 / static_cast<double>(rate.load());
  while (started && next_tick <= t + 1e-9) {
    Core::StepTo(std::max(next_tick, manual_now_.load()));
    Tick();
    next_tick += period;
  }
  Core::StepTo(std::max(t, manual_now_.load()));
}

namespace {
Hd hd;

}  // namespace

Core& TheCore() {
  return hd;
}

namespace {
const Start start(hd, "HD");
}

FAKE_EXPORT Handle hdInitDevice(const char* name) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return kInvalidHandle;
  const bool known = name ? hd.Text("name") == name : hd.Number("null") != 0;
  if (!hd.plugged || !known || hd.inits++ < hd.Number("init_failures")) {
    hd.Push(kDeviceFault);
    return kInvalidHandle;
  }
  if (hd.initiated != kInvalidHandle) {
    hd.Push(kAlreadyInitiated);
    return kInvalidHandle;
  }
  const auto handle = static_cast<Handle>(hd.Number("handle"));
  if (handle > 1024) return handle;  // garbage, which is no device
  hd.initiated = hd.current = handle;
  hd.lost = false;
  hd.enabled.clear();
  hd.enabled.insert(kRamping);
  hd.enabled.insert(kForceLimit);
  hd.velocity_limit = hd.Number("velocity_limit");
  hd.ramp_rate = hd.Number("ramp");
  hd.Take();
  return handle;
}

FAKE_EXPORT void hdDisableDevice(Handle device) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return;
  if (device == kInvalidHandle || device != hd.initiated) return hd.Push(kBadHandle);
  hd.initiated = hd.current = kInvalidHandle;
  hd.in_frame = false;
  hd.enabled.clear();
  hd.asked.setZero();
  hd.motors.setZero();
}

FAKE_EXPORT void hdMakeCurrentDevice(Handle device) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return;
  if (device == kInvalidHandle || device != hd.initiated) return hd.Push(kBadHandle);
  hd.current = device;
}

FAKE_EXPORT Handle hdGetCurrentDevice() {
  const Guard guard(hd.mutex);
  hd.Begins(__func__);
  return hd.current;
}

// Queries between hdBeginFrame and hdEndFrame give one state; after it they give that of the last
// frame.
FAKE_EXPORT void hdBeginFrame(Handle device) {
  const Guard guard(hd.mutex);
  const bool good = hd.Begins(__func__);
  if (device == kInvalidHandle || device != hd.initiated) return hd.Push(kBadHandle);
  if (hd.in_frame) return hd.Push(kIllegalBegin);
  hd.in_frame = true;
  if (!hd.plugged || hd.lost) return hd.Push(kCommError);
  if (good) hd.Take();
}

// The force of the frame goes to the motors. What is set holds until another is set.
FAKE_EXPORT void hdEndFrame(Handle device) {
  const Guard guard(hd.mutex);
  const bool good = hd.Begins(__func__);
  if (device == kInvalidHandle || device != hd.initiated) return hd.Push(kBadHandle);
  if (!hd.in_frame) return hd.Push(kIllegalEnd);
  hd.in_frame = false;
  if (!hd.plugged || hd.lost) return hd.Push(kCommError);
  if (hd.frozen || !good) return;
  Vector3d force = hd.asked;
  const double most = hd.model().max_force;
  if (!force.allFinite()) {
    hd.Push(kForceError);
    force.setZero();
  } else if (force.norm() > most && hd.enabled.contains(kClamping)) {
    force *= most / force.norm();
  } else if (force.norm() > most) {
    hd.Push(kTooMuchForce);
    if (hd.enabled.contains(kForceLimit)) force.setZero();
  }
  if (hd.v.norm() > hd.velocity_limit && hd.enabled.contains(kForceLimit)) {
    hd.Push(kTooFast);
    force.setZero();
  }
  if (hd.hot) hd.Push(kWarmMotors);
  hd.motors = force;
  const Vector3d torque = hd.torque / 1000;
  hd.Core::Log({hd.asked.x(), hd.asked.y(), hd.asked.z(), torque.x(), torque.y(), torque.z(), 0});
}

#ifndef FAKE_MISSING
FAKE_EXPORT ErrorInfo hdGetError() {
  const Guard guard(hd.mutex);
  hd.Enter(__func__);
  if (hd.errors.empty()) return {0, 0, hd.current};
  const ErrorInfo first = hd.errors.front();
  hd.errors.erase(hd.errors.begin());
  return first;
}
#endif

FAKE_EXPORT const char* hdGetErrorString(unsigned code) {
  static const std::map<unsigned, const char*> words = {
      {0, "no error"},
      {kWarmMotors, "warm motors"},
      {kTooMuchForce, "exceeded maximum force"},
      {kTooFast, "exceeded maximum velocity"},
      {kDeviceFault, "device fault"},
      {kAlreadyInitiated, "device already initiated"},
      {kCommError, "communication error"}};
  const auto found = words.find(code);
  return found == words.end() ? "other error" : found->second;
}

FAKE_EXPORT void hdEnable(unsigned capability) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__) || !hd.HasDevice()) return;
  if (capability < kForceOutput || capability > kForceLimit) return hd.Push(kInvalidEnum);
  if (capability == kForceOutput && !hd.enabled.contains(capability)) hd.enabled_since = hd.time;
  hd.enabled.insert(capability);
}

FAKE_EXPORT void hdDisable(unsigned capability) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__) || !hd.HasDevice()) return;
  if (!hd.enabled.contains(capability)) hd.Push(kInvalidEnum);
  hd.enabled.erase(capability);
}

FAKE_EXPORT unsigned char hdIsEnabled(unsigned capability) {
  const Guard guard(hd.mutex);
  return hd.Begins(__func__) && hd.HasDevice() && hd.enabled.contains(capability);
}

// Values of each type are read and written alike.
// clang-format off
FAKE_EXPORT void hdGetBooleanv(unsigned name, unsigned char* to) { hd.Get(name, to, kBoolean, __func__); }
FAKE_EXPORT void hdGetIntegerv(unsigned name, int* to) { hd.Get(name, to, kInteger, __func__); }
FAKE_EXPORT void hdGetFloatv(unsigned name, float* to) { hd.Get(name, to, kFloat, __func__); }
FAKE_EXPORT void hdGetDoublev(unsigned name, double* to) { hd.Get(name, to, kDouble, __func__); }
FAKE_EXPORT void hdGetLongv(unsigned name, long* to) { hd.Get(name, to, kLong, __func__); }
FAKE_EXPORT void hdSetBooleanv(unsigned name, const unsigned char* from) { hd.Set(name, from, kBoolean, __func__); }
FAKE_EXPORT void hdSetIntegerv(unsigned name, const int* from) { hd.Set(name, from, kInteger, __func__); }
FAKE_EXPORT void hdSetFloatv(unsigned name, const float* from) { hd.Set(name, from, kFloat, __func__); }
FAKE_EXPORT void hdSetDoublev(unsigned name, const double* from) { hd.Set(name, from, kDouble, __func__); }
FAKE_EXPORT void hdSetLongv(unsigned name, const long* from) { hd.Set(name, from, kLong, __func__); }
// clang-format on

FAKE_EXPORT const char* hdGetString(unsigned name) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return "";
#ifdef FAKE_OLD
  if (name == 0x2500 || name == 0x2502) return "1.02.14";
#else
  if (name == 0x2500 || name == 0x2502) return "3.5.0";
#endif
  if (!hd.HasDevice()) return "";
  if (name == 0x2501) return hd.model().name;
  if (name == 0x2503) return "3D Systems";
  if (name == 0x2504) return hd.Text("serial").c_str();
  hd.Push(kInvalidEnum);
  return "";
}

FAKE_EXPORT unsigned hdCheckCalibration() {
  const Guard guard(hd.mutex);
  return hd.Begins(__func__) && hd.HasDevice() ? hd.Calibration() : kNeedsManual;
}

FAKE_EXPORT unsigned hdCheckCalibrationStyle() {
  const Guard guard(hd.mutex);
  return hd.Begins(__func__) && hd.HasDevice() ? static_cast<unsigned>(hd.Number("style")) : 0;
}

FAKE_EXPORT void hdUpdateCalibration(unsigned style) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__) || !hd.HasDevice()) return;
  if (style != static_cast<unsigned>(hd.Number("style"))) return hd.Push(kInvalidValue);
  if (hd.Calibration() == kNeedsManual) return hd.Push(kInvalidOperation);
  hd.SetOption("calibration", "ok");
}

FAKE_EXPORT void hdStartScheduler() {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return;
  if (hd.started) return hd.Push(kInvalidOperation);
  if (hd.servo.joinable()) hd.servo.join();
  hd.started = true;
  hd.enabled_since = hd.next_tick = hd.time;
  if (!hd.manual()) hd.servo = std::thread([] { hd.RunServo(); });
}

FAKE_EXPORT void hdStopScheduler() {
  {
    const Guard guard(hd.mutex);
    if (!hd.Begins(__func__)) return;
    if (!hd.started || std::this_thread::get_id() == hd.servo.get_id())
      return hd.Push(kInvalidOperation);
  }
  hd.StopServo();
}

#ifndef FAKE_OLD
FAKE_EXPORT void hdSetSchedulerRate(unsigned long hertz) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return;
  if (hertz != 500 && hertz != 1000) return hd.Push(kInvalidValue);
  hd.rate = hertz;
}
#endif

#ifndef FAKE_MISSING
FAKE_EXPORT unsigned long hdScheduleAsynchronous(Callback call, void* data,
                                                 unsigned short priority) {
  {
    const Guard guard(hd.mutex);
    if (!hd.Begins(__func__)) return 0;
  }
  const Guard lists(hd.running);
  return hd.Add(call, data, priority);
}
#endif

// Returns when the callback is done. Without a running scheduler nobody would run it: an error.
// Under an injected clock it runs here.
FAKE_EXPORT void hdScheduleSynchronous(Callback call, void* data, unsigned short priority) {
  {
    const Guard guard(hd.mutex);
    if (!hd.Begins(__func__)) return;
    if (!hd.started) return hd.Push(kInvalidOperation);
  }
  if (hd.manual() || std::this_thread::get_id() == hd.servo.get_id()) {
    while (call(data) != 0 && hd.manual()) hd.StepTo(hd.next_tick);
    return;
  }
  std::unique_lock<std::recursive_mutex> lists(hd.running);
  const unsigned long id = hd.Add(call, data, priority);
  hd.done.wait(lists, [id] { return !hd.IsScheduled(id); });
}

FAKE_EXPORT void hdUnschedule(unsigned long id) {
  const Guard lists(hd.running);
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return;
  if (std::erase_if(hd.scheduled, [id](auto& one) { return one.id == id; }) == 0)
    hd.Push(kInvalidValue);
}

// `mode` 0: whether the callback is still scheduled; 1: waits until it is not.
FAKE_EXPORT unsigned char hdWaitForCompletion(unsigned long id, unsigned mode) {
  std::unique_lock<std::recursive_mutex> lists(hd.running);
  if (mode == 0) return hd.IsScheduled(id);
  while (hd.manual() && hd.IsScheduled(id)) hd.StepTo(hd.next_tick);
  hd.done.wait(lists, [id] { return !hd.IsScheduled(id); });
  return 0;
}

// Since the tick began [s].
FAKE_EXPORT double hdGetSchedulerTimeStamp() {
  const Guard guard(hd.mutex);
  hd.Enter(__func__);
  return hd.time - hd.tick_at;
}

}  // namespace palpate::fakes
