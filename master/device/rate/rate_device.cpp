#include "master/device/rate/rate_device.h"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr auto kPollEvery = std::chrono::milliseconds(5);
constexpr double kMaxStep = 0.1;  // longest simulated time between readings [s]
constexpr double kUsual = 20, kSlowest = 0.1, kFastest = 200;  // [mm/s]

}  // namespace

RateDevice::RateDevice(std::unique_ptr<RateSource> source, double speed, bool polls)
    : HapticDevice(CapabilitiesOfArm()),
      source_(std::move(source)),
      speed_(speed),
      description_(source_->description() + Formatted(", up to %g mm/s", 1e3 * speed)),
      hand_(Arm()) {
  RequirePositive("speed", speed);
  if (!polls) return;
  thread_ = std::jthread([this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      Poll(Clock::now());
      std::this_thread::sleep_for(kPollEvery);
    }
    source_->Cue(0, Clock::now());
  });
}

void RateDevice::Poll(Time now) {
  RateInput input = source_->Poll(now);
  input.received_at = now;
  inputs_.Put(input);
  const bool is_recent = SecondsBetween(written_at_, now) < kLetGoAfter;
  source_->Cue(is_recent ? force_share_.load() : 0, now);
}

DeviceReading RateDevice::DoRead(Time now) noexcept {
  const double dt = last_ ? std::clamp(SecondsBetween(*last_, now), 0.0, kMaxStep) : 0;
  last_ = now;
  if (const RateInput* newest = inputs_.Take()) input_ = *newest;
  const double age = SecondsBetween(input_.received_at, now);
  const bool good = input_.fault == DeviceFault::kNone && age < kSilentAfter;
  const bool moves = good && input_.engaged && age < kStopAfter;
  intent_.v_M = moves ? Eigen::Vector3d(speed_ * input_.share) : Eigen::Vector3d(0, 0, 0);
  if (!good || !input_.engaged) intent_.p_M = hand_.p_M();  // a released device stays
  intent_.p_M += dt * intent_.v_M;
  hand_.Step(dt, intent_);
  DeviceReading reading{hand_.p_M(), hand_.v_M(), good && input_.engaged};
  reading.at = input_.received_at;
  reading.status.buttons = input_.buttons;
  reading.status.fault = input_.fault;
  reading.status.cause = input_.cause;
  if (input_.fault == DeviceFault::kNone && !good) reading.status.fault = DeviceFault::kSilent;
  return reading;
}

DeviceOutput RateDevice::DoWrite(const Wrench& wrench) noexcept {
  hand_.ApplyForce(wrench.force);
  force_share_ = std::min(1.0, wrench.force.norm() / limits().force);
  if (last_) written_at_ = *last_;
  return DeviceOutput::kOk;
}

double SpeedOf(const std::string& device, const std::string& option) {
  if (option.empty()) return 1e-3 * kUsual;
  const auto speed = ParseFinite(option);
  if (speed && *speed >= kSlowest && *speed <= kFastest) return 1e-3 * *speed;
  throw std::invalid_argument("--device " + device + ":" + option +
                              ": expected the speed at full deflection, 0.1 to 200 mm/s");
}

}  // namespace palpate
