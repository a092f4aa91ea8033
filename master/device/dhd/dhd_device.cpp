#include "master/device/dhd/dhd_device.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <utility>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

// The library's frame D has x towards the operator, y to the right, z up.
Eigen::Vector3d FromD(const Eigen::Vector3d& d) {
  return {d.y(), d.z(), d.x()};
}
Eigen::Vector3d ToD(const Eigen::Vector3d& m) {
  return {m.z(), m.x(), m.y()};
}
// R_MD, column by column.
Eigen::Matrix3d RotationToM() {
  Eigen::Matrix3d R;
  R << FromD({1, 0, 0}), FromD({0, 1, 0}), FromD({0, 0, 1});
  return R;
}

constexpr double kClosedGap = 0.010;  // a gripper closed to this gap counts as the first button [m]
constexpr std::chrono::milliseconds kTickPeriod(1);
constexpr int kStatusRoom = 64;  // releases write 12 to 17 numbers

constexpr std::array<const char*, 7> kForceOffCauses{
    "",         "force button",     "velocity limit",   "no command in time",
    "software", "USB disconnected", "dead-man's switch"};

// Limits by model, where the library reports none: those of CHAI3D.
struct Model {
  std::string_view name;
  double force, torque, stiffness;  // [N], [N m], [N/m]
};
constexpr std::array<Model, 5> kModels{{{"omega", 12, 0, 5000},
                                        {"delta", 20, 0, 5000},
                                        {"sigma", 12, 0.2, 4000},
                                        {"lambda", 12, 0.2, 8000},
                                        {"falcon", 8, 0, 3000}}};

DeviceCapabilities CapabilitiesOf(const DhdApi& api, char id, const std::string& name) {
  DeviceCapabilities own;
  Model limits{"", 8, 0, 3000};  // an unknown model has the lowest limits
  for (const Model& model : kModels) {
    if (Lowercase(name).find(model.name) != std::string::npos) limits = model;
  }
  const bool active_wrist = api.has_active_wrist(id);
  own.sensed_dof = api.has_wrist(id) ? 6 : 3;
  own.actuated_dof = active_wrist ? 6 : 3;
  const double stated = api.max_force == nullptr ? 0 : api.max_force(id);
  own.force = stated > 0 ? std::min(stated, limits.force) : limits.force;
  own.continuous_force = own.force;
  own.torque = own.continuous_torque = active_wrist ? limits.torque : 0;
  own.stiffness = limits.stiffness;
  own.rate = 1000;
  return own;
}

// A failed transfer may succeed later, unlike a missing device.
DeviceFault FaultOfDhd(int code) {
  switch (code) {
    case dhd::kCommunication:
      return DeviceFault::kSilent;
    case dhd::kNoDevice:
      return DeviceFault::kUnplugged;
    default:
      return DeviceFault::kDriver;
  }
}

std::string LastError(const DhdApi& api) {
  const char* words = api.last_error_text();
  return words == nullptr ? "no reason given" : words;
}

}  // namespace

DhdDevice::Opened DhdDevice::OpenDevice(const Options& options) {
  Opened opened;
  DhdApi& api = opened.api;
  const std::string problem = api.Load(DhdSearch(options.folders));
  if (!problem.empty()) throw DeviceUnavailable("dhd", problem);
  if (api.device_count() <= 0) {
    throw DeviceUnavailable("dhd",
                            "no device is connected, or another program has opened it, or "
                            "its USB node may not be opened by this user");
  }
  const int id = options.serial ? api.open_serial(*options.serial) : api.open();
  if (id < 0) throw DeviceUnavailable("dhd", "the device does not open: " + LastError(api));
  opened.id = static_cast<char>(id);
  const char* name = api.system_name(opened.id);
  const std::string model = name == nullptr ? "unknown model" : name;
  opened.capabilities = CapabilitiesOf(api, opened.id, model);
  opened.has_wrist = api.has_wrist(opened.id);
  opened.has_gripper = api.has_gripper(opened.id);
  std::array<int, 4> version{};
  api.sdk_version(&version[0], &version[1], &version[2], &version[3]);
  opened.description =
      "dhd: " + model + Formatted(", SDK %d.%d.%d", version[0], version[1], version[2]);
  return opened;
}

std::unique_ptr<DhdDevice> DhdDevice::Open(const Options& options) {
  return std::unique_ptr<DhdDevice>(new DhdDevice(OpenDevice(options), options.own_thread));
}

DhdDevice::DhdDevice(Opened opened, bool own_thread)
    : HapticDevice(opened.capabilities),
      own_(std::move(opened)),
      description_(own_.description),
      R_MD_(RotationToM()),
      may_thread_(own_thread) {
  newest_.repeated = last_.repeated = true;
}

DhdDevice::~DhdDevice() {
  StopTicks();
  Send({});
  own_.api.enable_force(0, own_.id);
  own_.api.stop(own_.id);
  own_.api.close(own_.id);
}

bool DhdDevice::Succeeded(int code) noexcept {
  if (code >= 0) return true;
  if (status_.fault != DeviceFault::kNone) return false;  // the first error is reported
  status_.code = own_.api.last_error();
  status_.fault = FaultOfDhd(status_.code);
  const char* words = own_.api.last_error_text();
  if (words != nullptr) status_.cause = words;
  return false;
}

bool DhdDevice::StartTicks(const Tick* tick) {
  if (!may_thread_) return false;
  threaded_ = true;
  thread_ = std::jthread([this, tick](const std::stop_token& stop) { RunTicks(*tick, stop); });
  return true;
}

void DhdDevice::StopTicks() {
  if (!threaded_) return;
  thread_.request_stop();
  thread_.join();
  threaded_ = false;
}

void DhdDevice::RunTicks(const Tick& tick, const std::stop_token& stop) noexcept {
  MakeThreadRealtime(kHapticPriority);
  Command command;
  for (Time wake = Clock::now(); !stop.stop_requested();) {
    frames_.Put(Measure(Clock::now()));
    tick(Clock::now());
    if (const Command* newest = commands_.Take()) command = *newest;
    const bool is_new = SecondsBetween(command.at, Clock::now()) < kLetGoAfter;
    output_ = Send(is_new ? command.wrench : Wrench());
    wake = std::max(wake + kTickPeriod, Clock::now());
    std::this_thread::sleep_until(Clock::ToSteady(wake));
  }
}

DeviceReading DhdDevice::DoRead(Time now) noexcept {
  if (!threaded_) return Measure(now);
  read_at_ = now;
  const DeviceReading* frame = frames_.Take();
  if (frame != nullptr) newest_ = *frame;
  newest_.repeated = newest_.repeated || frame == nullptr;
  return newest_;
}

DeviceOutput DhdDevice::DoWrite(const Wrench& wrench) noexcept {
  if (!threaded_) return Send(wrench);
  commands_.Put({wrench, read_at_});
  return output_;
}

DeviceReading DhdDevice::Measure(Time now) noexcept {
  status_ = DeviceStatus();  // the library reports no calibration: its own tool calibrates
  DeviceReading reading = last_;
  ReadMotion(&reading);
  ReadButtons();
  if (status_.fault == DeviceFault::kNone) ReadForceOff();
  if (status_.fault == DeviceFault::kNone) ReadForceShare();
  if (status_.fault == DeviceFault::kNone && write_failed_) status_ = write_status_;
  if (!reading.repeated) reading.at = now;
  reading.engaged = (status_.buttons & 1U) != 0;
  reading.status = status_;
  return last_ = reading;
}

void DhdDevice::ReadMotion(DeviceReading* reading) noexcept {
  const DhdApi& api = own_.api;
  Eigen::Vector3d p(0, 0, 0), v(0, 0, 0);
  const int moved = api.position(&p.x(), &p.y(), &p.z(), own_.id);
  reading->repeated = moved == dhd::kTimeGuard;
  if (Succeeded(moved)) reading->p_M = FromD(p);
  if (Succeeded(api.velocity(&v.x(), &v.y(), &v.z(), own_.id))) reading->v_M = FromD(v);
  if (!own_.has_wrist) return;
  double frame[3][3] = {};
  if (!Succeeded(api.orientation(frame, own_.id))) return;
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> R(&frame[0][0]);
  reading->q_M = Eigen::Quaterniond(Eigen::Matrix3d(R_MD_ * R * R_MD_.transpose()));
}

void DhdDevice::ReadButtons() noexcept {
  status_.buttons = own_.api.buttons(own_.id);
  double gap = 1;
  if (!own_.has_gripper || !Succeeded(own_.api.gripper_gap(&gap, own_.id))) return;
  if (std::abs(gap) <= kClosedGap) status_.buttons |= 1U;
}

void DhdDevice::ReadForceShare() noexcept {
  if (own_.api.rendered_force == nullptr || sent_.norm() < kMinCompared) return;
  Eigen::Vector3d rendered(0, 0, 0);
  if (!Succeeded(own_.api.rendered_force(&rendered.x(), &rendered.y(), &rendered.z(), own_.id))) {
    return;
  }
  status_.force_share = static_cast<float>(rendered.dot(sent_) / sent_.squaredNorm());
}

// A deliberate press of the first button switches the force on again.
void DhdDevice::ReadForceOff() noexcept {
  const bool pressed = (status_.buttons & 1U) != 0;
  const bool asks = pressed && !was_pressed_;
  was_pressed_ = pressed;
  if (!enabled_) return;
  std::array<int, kStatusRoom> all{};
  if (!Succeeded(own_.api.status(all.data(), own_.id)) || all[dhd::kStatusForce] != 0) return;
  const auto cause = static_cast<std::size_t>(all[dhd::kStatusForceOffCause]);
  status_.fault = DeviceFault::kForceOff;
  status_.code = all[dhd::kStatusForceOffCause];
  status_.cause = cause < kForceOffCauses.size() ? kForceOffCauses[cause] : "unknown cause";
  if (asks) EnableForce();
}

void DhdDevice::EnableForce() noexcept {
  enabled_ = Succeeded(own_.api.enable_force(1, own_.id)) || enabled_;
}

DeviceOutput DhdDevice::Send(const Wrench& wrench) noexcept {
  status_ = DeviceStatus();
  const bool had_reading = last_.at != Time{} && last_.status.fault == DeviceFault::kNone;
  if (!enabled_ && had_reading) EnableForce();
  const Eigen::Vector3d f = ToD(wrench.force), t = ToD(wrench.torque);
  const int code =
      capabilities().torque > 0
          ? own_.api.set_force_and_torque(f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), own_.id)
          : own_.api.set_force(f.x(), f.y(), f.z(), own_.id);
  sent_ = f;
  write_failed_ = !Succeeded(code) || status_.fault != DeviceFault::kNone;
  write_status_ = status_;
  if (write_failed_) return DeviceOutput::kOff;
  return code == dhd::kSaturated ? DeviceOutput::kSaturated : DeviceOutput::kOk;
}

Driver DhdDriver() {
  return {"dhd", "Force Dimension omega, delta, sigma, lambda; Novint Falcon (Force Dimension SDK)",
          "serial number of the device",
          [] {
            DriverReport report;
            const LibrarySearch search = DhdSearch({});
            AddLibrary(search, SharedLibrary(search), &report);
            if (report.missing.empty()) {
              AddOpened(DhdDriver(), &report);
            } else {
              report.next = "install the Force Dimension SDK and set FORCEDIM_SDK to its folder";
            }
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            DhdDevice::Options options;
            if (!option.empty()) {
              const auto serial = ParseFinite(option);
              if (!serial || *serial < 0 || *serial > 1e9 || *serial != std::floor(*serial)) {
                throw std::invalid_argument("--device dhd:" + option +
                                            ": expected the serial number of the device");
              }
              options.serial = static_cast<int>(*serial);
            }
            return DhdDevice::Open(options);
          }};
}

}  // namespace palpate
