#include "slave/live/simulated_drivers.h"

#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "shared/state/driven_clock.h"
#include "shared/wire/fields.h"
#include "slave/capture/tactile_inbox.h"
#include "slave/live/driver_messages.h"
#include "slave/manipulator/streamed_manipulator.h"

namespace palpate {
namespace {

constexpr const char* kName = "simulator";
constexpr Clock::duration kReportPeriod = std::chrono::milliseconds(2);

// The drivers' clock is zero when the driven clock begins.
Time Reached(Time drivers_clock) {
  const Time now = DrivenClock::kBegin + drivers_clock.time_since_epoch();
  DrivenClock::Reach(now);
  return now;
}

Time StampOf(const google::protobuf::Timestamp& message) {
  return Time(std::chrono::seconds(message.seconds()) + std::chrono::nanoseconds(message.nanos()));
}

[[noreturn]] void Refused(const std::string& why) {
  throw std::runtime_error(fmt::format("{}: {}", kName, why));
}

}  // namespace

void SimulatedDrivers::Send(const v1::SimulatedSample& sample) {
  const bool has_images = sample.has_images();
  if (!has_images && sample.fingertips().empty()) Refused("a sample without images or fingertips");
  SendReports(sample.truth(),
              StampOf(has_images ? sample.images().sensed_at() : sample.fingertips(0).sensed_at()));
  if (has_images) SendImages(sample.images());
  for (const v1::TactileSample& fingertip : sample.fingertips()) SendTactile(fingertip);
}

void SimulatedDrivers::SendReports(const v1::SimulatedTruth& truth, Time sensed_at) {
  if (slave_.driven_arm() == nullptr) return;
  const v1::Vec3& tip = truth.p_s_tip();
  const Eigen::Vector3d from = p_S_tip_, to(tip.x(), tip.y(), tip.z());
  const Time begin = reported_at_;
  if (reports_ > 0) {
    for (Time t = begin + kReportPeriod; t < sensed_at; t += kReportPeriod) {
      const double share = SecondsBetween(begin, t) / SecondsBetween(begin, sensed_at);
      Report(from + share * (to - from), t, nullptr);
    }
  }
  Report(to, sensed_at, &truth);
}

void SimulatedDrivers::Report(const Eigen::Vector3d& p_S_tip, Time at,
                              const v1::SimulatedTruth* truth) {
  v1::ArmReport report;
  report.set_sequence(++reports_);
  ToProto(at, report.mutable_measured_at());
  ToProto(p_S_tip, report.mutable_p_s_tip());
  if (truth != nullptr && truth->solved() && !truth->has_target()) {
    *report.mutable_measured_force() = truth->force();
  }
  std::string reason;
  const auto reading = FromProto(report, &reason);
  if (!reading) Refused(reason);
  const auto refusal = slave_.driven_arm()->Take(kId, kName, *reading, Reached(at));
  if (refusal) Refused(refusal->why);
  p_S_tip_ = p_S_tip;
  reported_at_ = at;
}

void SimulatedDrivers::SendImages(const v1::ImageSample& images) {
  std::string reason;
  const auto sample = FromProto(images, &reason);
  if (!sample) Refused(reason);
  const auto refusal = slave_.image_inbox()->Feed(*sample, Reached(sample->sensed_at), kId);
  if (refusal) Refused(refusal->why);
}

void SimulatedDrivers::SendTactile(const v1::TactileSample& message) {
  std::string reason;
  const auto sample = FromProto(message, &reason);
  if (!sample) Refused(reason);
  const auto refusal =
      slave_.tactile_inbox()->Feed(message.finger(), message.sequence(), sample->sensed_at,
                                   sample->reading, Reached(sample->sensed_at), kId);
  if (refusal) Refused(message.finger() + " " + refusal->why);
}

}  // namespace palpate
