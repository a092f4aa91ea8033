// A fake of OpenHaptics HDAPI with one device, a servo thread and a queue of errors.
#include "tests/master/device/fakes/fake_hd.h"

namespace palpate::fakes {

Hd::Values Hd::Find(unsigned name) const {
  const auto numbers = [](std::initializer_list<double> all) {
    Values values{{}, static_cast<std::ptrdiff_t>(all.size())};
    std::copy(all.begin(), all.end(), values.all.begin());
    return values;
  };
  const auto list = [&](const Vector3d& a) { return numbers({a.x(), a.y(), a.z()}); };
  if (name == 0x2000) return numbers({double(frame.buttons)});
  if (name == 0x2050) return list(1000 * frame.p);
  if (name == 0x2051) return list(1000 * frame.v);
  if (name == 0x2052) {
    Values values{{}, 16};
    Eigen::Map<Eigen::Matrix4d> transform(values.all.data());  // columns one after another
    transform.setIdentity();
    transform.topRightCorner<3, 1>() = 1000 * frame.p;
    return values;
  }
  if (name == 0x2053) return numbers({0, 0, 0});
  if (name == 0x2551) return numbers({-80, -60, -35, 80, 60, 35});
  if (name == 0x2553) return numbers({6});
  if (name == 0x2554) return numbers({3});
  if (name == 0x2600) return numbers({1000});
  if (name == 0x2602) return numbers({0.5});
  if (name == 0x2603) return numbers({kMaxForce});
  if (name == 0x2604) return numbers({kContinuousForce});
  if (name == 0x2605) return numbers({heat, heat, heat, heat, heat, heat});
  if (name == 0x2609) return numbers({0.003});
  return {};
}

void Hd::SetForce(unsigned name, const double* values, const char* function) {
  const Guard guard(mutex);
  if (!Begins(function) || !HasDevice()) return;
  if (name != 0x2700) return Push(kInvalidEnum);
  if (!in_frame) return Push(kFrameError);
  asked = Vector3d(values[0], values[1], values[2]);
}

bool Hd::IsScheduled(unsigned long id) const {
  return std::any_of(scheduled.begin(), scheduled.end(), [id](auto& one) { return one.id == id; });
}

// `running` is locked.
unsigned long Hd::Add(Callback call, void* data) {
  if (scheduled.size() == kMaxCallbacks) {
    const Guard guard(mutex);
    Push(kSchedulerFull);
    return 0;
  }
  scheduled.push_back({++last_id, call, data});
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
}

void Hd::Tick() {
  bool runs = false;
  {
    const Guard guard(mutex);
    Sync();
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
    wake += kTickPeriod;
    const auto now = std::chrono::steady_clock::now();
    while (wake < now) wake += kTickPeriod;
    std::this_thread::sleep_until(wake);
  }
}

void Hd::StopServo() {
  started = false;
  if (servo.joinable()) servo.join();
}

// A tick at each period of the injected clock.
void Hd::StepTo(double t) {
  const double period = std::chrono::duration<double>(kTickPeriod).count();
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

FAKE_EXPORT Handle hdInitDevice(const char* /*name*/) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return kInvalidHandle;
  if (!hd.plugged) {
    hd.Push(kDeviceFault);
    return kInvalidHandle;
  }
  if (hd.initiated != kInvalidHandle) {
    hd.Push(kAlreadyInitiated);
    return kInvalidHandle;
  }
  hd.initiated = hd.current = 0;
  hd.lost = false;
  hd.enabled.clear();
  hd.enabled.insert(kRamping);
  hd.enabled.insert(kForceLimit);
  hd.Take();
  return hd.current;
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

// Queries between hdBeginFrame and hdEndFrame return one state; later queries return the state of
// the last frame.
FAKE_EXPORT void hdBeginFrame(Handle device) {
  const Guard guard(hd.mutex);
  const bool good = hd.Begins(__func__);
  if (device == kInvalidHandle || device != hd.initiated) return hd.Push(kBadHandle);
  if (hd.in_frame) return hd.Push(kIllegalBegin);
  hd.in_frame = true;
  if (!hd.plugged || hd.lost) return hd.Push(kCommError);
  if (good) hd.Take();
}

// Applies the force of the frame to the motors. A force remains set until another one is set.
FAKE_EXPORT void hdEndFrame(Handle device) {
  const Guard guard(hd.mutex);
  const bool good = hd.Begins(__func__);
  if (device == kInvalidHandle || device != hd.initiated) return hd.Push(kBadHandle);
  if (!hd.in_frame) return hd.Push(kIllegalEnd);
  hd.in_frame = false;
  if (!hd.plugged || hd.lost) return hd.Push(kCommError);
  if (hd.frozen || !good) return;
  Vector3d force = hd.asked;
  const double most = kMaxForce;
  if (!force.allFinite()) {
    hd.Push(kForceError);
    force.setZero();
  } else if (force.norm() > most && hd.enabled.contains(kClamping)) {
    force *= most / force.norm();
  } else if (force.norm() > most) {
    hd.Push(kTooMuchForce);
    if (hd.enabled.contains(kForceLimit)) force.setZero();
  }
  if (hd.v.norm() > kVelocityLimit && hd.enabled.contains(kForceLimit)) {
    hd.Push(kTooFast);
    force.setZero();
  }
  if (hd.hot) hd.Push(kWarmMotors);
  hd.motors = force;
  hd.Took(hd.asked);
}

FAKE_EXPORT ErrorInfo hdGetError() {
  const Guard guard(hd.mutex);
  hd.Enter(__func__);
  if (hd.errors.empty()) return {0, 0, hd.current};
  const ErrorInfo first = hd.errors.front();
  hd.errors.erase(hd.errors.begin());
  return first;
}

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

FAKE_EXPORT void hdGetIntegerv(unsigned name, int* to) {
  hd.Get(name, to, __func__);
}

FAKE_EXPORT void hdGetDoublev(unsigned name, double* to) {
  hd.Get(name, to, __func__);
}

FAKE_EXPORT void hdSetDoublev(unsigned name, const double* from) {
  hd.SetForce(name, from, __func__);
}

FAKE_EXPORT const char* hdGetString(unsigned name) {
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return "";
  if (!hd.HasDevice()) return "";
  if (name == 0x2501) return "Touch";
  if (name == 0x2504) return "012345678";
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

FAKE_EXPORT unsigned long hdScheduleAsynchronous(Callback call, void* data,
                                                 unsigned short /*priority*/) {
  {
    const Guard guard(hd.mutex);
    if (!hd.Begins(__func__)) return 0;
  }
  const Guard lists(hd.running);
  return hd.Add(call, data);
}

FAKE_EXPORT void hdUnschedule(unsigned long id) {
  const Guard lists(hd.running);
  const Guard guard(hd.mutex);
  if (!hd.Begins(__func__)) return;
  if (std::erase_if(hd.scheduled, [id](auto& one) { return one.id == id; }) == 0)
    hd.Push(kInvalidValue);
}

}  // namespace palpate::fakes
