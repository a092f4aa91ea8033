#include "master/device/haptic_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kTick = 0.001;         // longest step of the slew limit [s]
constexpr double kMaxReading = 100;     // largest position [m] and velocity [m/s]
constexpr double kRounding = 1 + 1e-9;  // the loop limits by the same bounds
constexpr double kUnit = 1e-2;          // deviation of the length of an orientation from 1 [-]

// Returns `wanted` shortened to the length `most`; zero if it is not finite. Reports whether it was
// changed.
Eigen::Vector3d Limited(const Eigen::Vector3d& wanted, double most, bool* changed) {
  if (!wanted.allFinite()) {
    *changed = true;
    return {0, 0, 0};
  }
  const double size = wanted.stableNorm();
  if (size <= most * kRounding) return wanted;
  *changed = true;
  return wanted * (most / size);
}

// Returns `last` moved towards `wanted` by at most `step`.
Eigen::Vector3d Stepped(const Eigen::Vector3d& last, const Eigen::Vector3d& wanted, double step,
                        bool* changed) {
  const Eigen::Vector3d way = wanted - last;
  const double size = way.norm();
  if (size <= step * kRounding) return wanted;
  *changed = true;
  return last + way * (step / size);
}

std::string Value(double value, const char* unit) {
  return Formatted("%.4g ", value) + unit;
}

}  // namespace

std::string InWords(const DeviceCapabilities& own) {
  std::string words = Formatted("%d axes sensed, ", own.sensed_dof);
  if (own.simulated) return words + "no force";
  words += Formatted("%d with force", own.actuated_dof);
  const auto add = [&words](double value, const char* name, const char* unit) {
    if (value > 0 && std::isfinite(value)) words += ", " + std::string(name) + Value(value, unit);
  };
  add(own.force, "up to ", "N");
  add(own.continuous_force, "continuous ", "N");
  add(own.torque, "up to ", "N m");
  add(own.continuous_torque, "continuous ", "N m");
  add(own.stiffness, "", "N/m");
  add(own.damping, "", "N s/m");
  if (!own.workspace.isEmpty()) {
    const Eigen::Vector3d size = 1e3 * own.workspace.sizes();
    words += Formatted(", workspace %.0f x %.0f x %.0f mm", size.x(), size.y(), size.z());
  }
  add(own.rate, "", "Hz");
  return words;
}

HapticDevice::HapticDevice(const DeviceCapabilities& capabilities)
    : capabilities_(capabilities), limit_(capabilities.force) {
  status_.calibration = CalibrationState::kUnknown;
  status_.output = DeviceOutput::kOff;
}

void HapticDevice::LowerForceLimit(double limit) noexcept {
  if (limit >= 0) limit_ = std::min(limit_, limit);
}

DeviceLimits HapticDevice::limits() const {
  constexpr double kTicksPerSecond = 1000;
  const double slew = capabilities_.simulated ? DeviceLimits::kUnlimited : kSlew / kTicksPerSecond;
  return {limit_, torque_limit(),     capabilities_.stiffness, capabilities_.damping,
          slew,   capabilities_.rate, senses_orientation()};
}

DeviceReading HapticDevice::Read(Time now) noexcept {
  DeviceReading reading = DoRead(now);
  read_at_ = now;
  CheckReading(&reading);
  const DeviceFault fault = reading.status.fault;
  usable_ = fault == DeviceFault::kNone;
  if (usable_) {
    must_release_ = must_release_ && reading.engaged;
    reading.q_M.normalize();
    turning_.Observe(reading.q_M, sent_.torque, reading.engaged && !must_release_);
  } else {
    must_release_ = true;
    DropForce();
    reading.v_M.setZero();
    reading.w_M.setZero();
  }
  reading.engaged = reading.engaged && !must_release_;
  reading.status.output = status_.output;
  status_ = reading.status;
  return reading;
}

bool HapticDevice::IsPossible(const DeviceReading& reading) const noexcept {
  const auto is_within = [](const Eigen::Vector3d& v) {
    return v.allFinite() && v.cwiseAbs().maxCoeff() <= kMaxReading;
  };
  return is_within(reading.p_M) && is_within(reading.v_M) &&
         (!senses_orientation() || std::abs(reading.q_M.norm() - 1) <= kUnit);
}

void HapticDevice::CheckReading(DeviceReading* reading) noexcept {
  DeviceStatus& status = reading->status;
  if (status.fault != DeviceFault::kNone) return;
  if (!reading->repeated) new_at_ = read_at_;
  if (!IsUsable(status.calibration)) {
    status.fault = DeviceFault::kNotCalibrated;
  } else if (SecondsBetween(new_at_, read_at_) >= kLetGoAfter) {
    status.fault = DeviceFault::kSilent;
  } else if (!IsPossible(*reading)) {
    status.fault = DeviceFault::kImpossible;
  }
}

void HapticDevice::WriteWrench(const Eigen::Vector3d& force_M,
                               const Eigen::Vector3d& torque_M) noexcept {
  if (!usable_) {
    DropForce();
    return;
  }
  bool changed = false;
  Wrench next{Limited(force_M, limit_, &changed), Limited(torque_M, torque_limit(), &changed)};
  if (!capabilities_.simulated) {
    const double dt = std::clamp(SecondsBetween(written_at_, read_at_), 0.0, kTick);
    // A torque needs as long to reach its largest value as the force.
    const double torque_slew = kSlew * capabilities_.torque / std::max(capabilities_.force, 1e-3);
    next.force = Stepped(sent_.force, next.force, kSlew * dt, &changed);
    next.torque = Stepped(sent_.torque, next.torque, torque_slew * dt, &changed);
  }
  next.torque = turning_.Apply(next.torque);
  written_at_ = read_at_;
  sent_ = next;
  status_.output = DoWrite(next);
  if (changed && status_.output == DeviceOutput::kOk) status_.output = DeviceOutput::kSaturated;
}

void HapticDevice::DropForce() noexcept {
  sent_ = {};
  written_at_ = read_at_;
  DoWrite(sent_);
  status_.output = DeviceOutput::kOff;
}

}  // namespace palpate
