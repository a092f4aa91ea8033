#include "master/device/touch/touch_device.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <thread>
#include <utility>

namespace palpate {
namespace {

constexpr double kMilli = 1e-3;              // the library's lengths are in mm
constexpr unsigned kMaxHandles = 1024;       // a larger handle is garbage
constexpr int kMaxErrors = 16;               // taken per frame
constexpr std::uint64_t kSlowFrames = 100;   // frames between checks of calibration and temperature
constexpr unsigned short kPriority = 65535;  // the highest
constexpr unsigned kSecondButton = 2;
constexpr auto kCallbackPoll = std::chrono::microseconds(200);

Eigen::Vector3d ReadVector(const HdApi& api, unsigned parameter) {
  std::array<double, 3> values{};
  api.get_doubles(parameter, values.data());
  return {values[0], values[1], values[2]};
}

double ReadNumber(const HdApi& api, unsigned parameter) {
  double value = 0;
  api.get_doubles(parameter, &value);
  return value;
}

int Integer(const HdApi& api, unsigned parameter) {
  int value = 0;
  api.get_integers(parameter, &value);
  return value;
}

std::string Text(const char* text) {
  return text == nullptr ? std::string() : std::string(text);
}

// Discards errors of parameters that a model does not have.
void ForgetErrors(const HdApi& api) {
  for (int i = 0; i < kMaxErrors && api.get_error().code != 0; ++i) {
  }
}

DeviceCapabilities CapabilitiesOf(const HdApi& api) {
  DeviceCapabilities own;
  const auto known = [](double value) {
    if (value > 0) return value;
    return DeviceCapabilities::kUnknown;
  };
  own.sensed_dof = Integer(api, hd::kInputDof);
  own.actuated_dof = std::min(Integer(api, hd::kOutputDof), 3);  // torques are not rendered
  own.force = known(ReadNumber(api, hd::kMaxForce));
  own.continuous_force = known(ReadNumber(api, hd::kMaxContinuousForce));
  own.stiffness = known(ReadNumber(api, hd::kMaxStiffness) / kMilli);
  own.damping = known(ReadNumber(api, hd::kMaxDamping) / kMilli);
  own.rate = Integer(api, hd::kUpdateRate);
  std::array<double, 6> box{};
  api.get_doubles(hd::kUsableWorkspace, box.data());
  own.workspace.extend(kMilli * Eigen::Vector3d(box[0], box[1], box[2]));
  own.workspace.extend(kMilli * Eigen::Vector3d(box[3], box[4], box[5]));
  if (own.workspace.sizes().isZero(0)) own.workspace.setEmpty();
  ForgetErrors(api);
  return own;
}

// A first call may fail, so a name is tried twice. A device with another name than the requested
// one is not used.
std::vector<const char*> NamesToTry(const std::string& name) {
  if (!name.empty()) return {name.c_str(), name.c_str()};
  return {nullptr, "Default Device", "Default PHANToM"};
}

// Returns the calibration style to use among those of a device.
unsigned StyleOf(unsigned styles) {
  for (const unsigned style : {hd::kInkwell, hd::kAutomatic, hd::kEncoderReset}) {
    if ((styles & style) != 0) return style;
  }
  return styles;
}

// Converts an error of the library to the fault of a running device.
DeviceFault FaultOfHd(unsigned code) {
  switch (code) {
    case hd::kWarmMotors:
      return DeviceFault::kHot;
    case hd::kExceededImpulse:
    case hd::kExceededVelocity:
      return DeviceFault::kForceOff;
    case hd::kCommunication:  // may succeed again
      return DeviceFault::kSilent;
    default:
      return DeviceFault::kDriver;
  }
}

}  // namespace

TouchDevice::Opened TouchDevice::OpenDevice(const Options& options) {
  Opened opened;
  const std::string problem = opened.api.Load(HdSearch(options.folders));
  if (!problem.empty()) throw DeviceUnavailable("touch", problem);
  const HdApi& api = opened.api;
  std::string refused;
  for (const char* name : NamesToTry(options.name)) {
    ForgetErrors(api);  // discards errors of an earlier session
    opened.handle = api.init_device(name);
    const HdError error = api.get_error();
    const bool is_handle = opened.handle != hd::kInvalidHandle && opened.handle <= kMaxHandles;
    if (error.code == 0 && is_handle) {
      api.make_current(opened.handle);
      opened.capabilities = CapabilitiesOf(api);
      opened.description = DescribeOpened(api);
      return opened;
    }
    if (!refused.empty()) refused += "; ";
    refused += std::string(name == nullptr ? "(default)" : name) + ": ";
    refused += error.code != 0 ? Text(api.error_text(error.code)) : "no valid handle";
    ForgetErrors(api);
  }
  throw DeviceUnavailable("touch", "no device opened: " + refused);
}

std::string TouchDevice::DescribeOpened(const HdApi& api) {
  const std::string model = Text(api.get_text(hd::kModel)),
                    serial = Text(api.get_text(hd::kSerial));
  ForgetErrors(api);
  return "touch: " + (model.empty() ? "unknown model" : model) +
         (serial.empty() ? "" : ", serial " + serial);
}

std::unique_ptr<TouchDevice> TouchDevice::Open(const Options& options) {
  return std::unique_ptr<TouchDevice>(new TouchDevice(OpenDevice(options), options.clock));
}

TouchDevice::TouchDevice(Opened opened, std::function<Time()> clock)
    : HapticDevice(opened.capabilities),
      api_(opened.api),
      handle_(opened.handle),
      description_(std::move(opened.description)),
      clock_(std::move(clock)) {
  newest_.status.calibration = status_.calibration = CalibrationState::kUnknown;
  newest_.repeated = true;
  std::array<double, 6> motors{};
  api_.get_doubles(hd::kMotorTemperature, motors.data());
  has_temperature_ = api_.get_error().code == 0;
  api_.enable(hd::kMaxForceClamping);
  api_.enable(hd::kSoftwareForceLimit);
  ForgetErrors(api_);
  task_ = api_.schedule(
      [](void* self) {
        static_cast<TouchDevice*>(self)->ServoFrame();
        return 1U;  // and again
      },
      this, kPriority);
  api_.start_scheduler();
}

TouchDevice::~TouchDevice() {
  StopTicks();
  api_.stop_scheduler();
  api_.unschedule(task_);
  api_.make_current(handle_);
  api_.disable(hd::kForceOutput);
  api_.disable_device(handle_);
  ForgetErrors(api_);
}

bool TouchDevice::StartTicks(const Tick* tick) {
  tick_ = tick;
  return true;
}

void TouchDevice::StopTicks() {
  tick_ = nullptr;
  while (inside_) std::this_thread::sleep_for(kCallbackPoll);
}

void TouchDevice::ServoFrame() noexcept {
  const Time now = clock_();
  api_.make_current(handle_);
  api_.begin_frame(handle_);
  frames_.Put(Measure(now));
  inside_ = true;
  if (const Tick* tick = tick_) (*tick)(now);
  inside_ = false;
  SendForce(now);
  api_.end_frame(handle_);
  status_.fault = DeviceFault::kNone;
  status_.code = 0;
  status_.cause = "";
  saturated_ = CollectErrors();  // of the force, for the next reading
  ++frame_;
}

DeviceReading TouchDevice::Measure(Time now) noexcept {
  if (frame_ % kSlowFrames == 0 || !IsUsable(status_.calibration)) Calibrate();
  if (has_temperature_ && frame_ % kSlowFrames == 0) {
    std::array<double, 6> motors{};
    api_.get_doubles(hd::kMotorTemperature, motors.data());
    status_.temperature = static_cast<float>(*std::ranges::max_element(motors));
  }
  std::array<double, 16> m{};  // column by column
  api_.get_doubles(hd::kTransform, m.data());
  Eigen::Matrix3d R;
  R << m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10];
  DeviceReading reading;
  reading.p_M = kMilli * ReadVector(api_, hd::kPosition);
  reading.v_M = kMilli * ReadVector(api_, hd::kVelocity);
  reading.q_M = Eigen::Quaterniond(R);
  reading.w_M = ReadVector(api_, hd::kAngularVelocity);
  reading.at = now;
  status_.buttons = static_cast<std::uint32_t>(Integer(api_, hd::kButtons));
  reading.engaged = (status_.buttons & 1U) != 0;
  CollectErrors();  // a reading with an error is not used
  reading.status = status_;
  return reading;
}

void TouchDevice::Calibrate() noexcept {
  const unsigned state = api_.check_calibration();
  if (state == hd::kCalibrated) {
    status_.calibration = CalibrationState::kCalibrated;
  } else if (state == hd::kNeedsUpdate) {
    const unsigned style =
        api_.calibration_style == nullptr ? 0 : StyleOf(api_.calibration_style());
    const bool ready = style != hd::kEncoderReset || (status_.buttons & kSecondButton) != 0;
    status_.calibration = ready ? CalibrationState::kPending : CalibrationState::kManual;
    if (ready) api_.update_calibration(style);
  } else {
    status_.calibration = CalibrationState::kManual;
  }
}

// The newest force, if it is of the last 20 ms. The output is enabled with the first one, zero as
// it is, after the calibration.
void TouchDevice::SendForce(Time now) noexcept {
  if (const Command* newest = commands_.Take()) command_ = *newest;
  const bool is_new = SecondsBetween(command_.at, now) < kLetGoAfter;
  const bool may = status_.fault == DeviceFault::kNone && IsUsable(status_.calibration);
  const Eigen::Vector3d force = is_new && may ? command_.force : Eigen::Vector3d(0, 0, 0);
  if (enabled_ != (may && (enabled_ || is_new))) {
    enabled_ = !enabled_;
    (enabled_ ? api_.enable : api_.disable)(hd::kForceOutput);
  }
  api_.set_doubles(hd::kCurrentForce, force.data());
}

bool TouchDevice::CollectErrors() noexcept {
  bool saturated = false;
  for (int i = 0; i < kMaxErrors; ++i) {
    const HdError error = api_.get_error();
    if (error.code == 0) break;
    if (error.code == hd::kExceededMaxForce) {
      saturated = true;
    } else if (error.code != hd::kInvalidParameter && status_.fault == DeviceFault::kNone) {
      status_.fault = FaultOfHd(error.code);
      status_.code = static_cast<std::int32_t>(error.code);
      const char* words = api_.error_text(error.code);
      if (words != nullptr) status_.cause = words;
    }
  }
  return saturated;
}

DeviceReading TouchDevice::DoRead(Time now) noexcept {
  read_at_ = now;
  const DeviceReading* frame = frames_.Take();
  if (frame != nullptr) newest_ = *frame;
  newest_.repeated = frame == nullptr;
  return newest_;
}

DeviceOutput TouchDevice::DoWrite(const Wrench& wrench) noexcept {
  commands_.Put({wrench.force, read_at_});
  return saturated_ ? DeviceOutput::kSaturated : DeviceOutput::kOk;
}

Driver TouchDriver() {
  return {"touch", "3D Systems Touch, Touch X, Omni, Desktop, Premium (OpenHaptics)",
          "name of the device in the vendor's configuration",
          [] {
            DriverReport report;
            const LibrarySearch search = HdSearch({});
            AddLibrary(search, SharedLibrary(search), &report);
            if (report.missing.empty()) {
              AddOpened(TouchDriver(), &report);
            } else {
              report.next =
                  "install OpenHaptics and the Touch driver of 3D Systems, set GTDD_HOME to its "
                  "folder, and pair the device with the vendor's setup program";
            }
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            TouchDevice::Options options;
            options.name = option;
            return TouchDevice::Open(options);
          }};
}

}  // namespace palpate
