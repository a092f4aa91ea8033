#include "master/device/haply/haply_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shared/link/thread_priority.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kExchangePeriod(1), kWait(20), kOpenWithin(300), kRetryEvery(200);
// Periods of kWait without an answer after which the connection is lost.
constexpr int kMaxWaits = 25;
constexpr double kSmooth = 0.010;  // smoothing time of computed velocities [s]
// Limits of the Inverse3, as its maker states them. The service reports no limits.
constexpr double kForce = 10, kRate = 1000;  // [N], [Hz]

// Frame H of the service: x to the right, y away from the operator, z up.
Eigen::Vector3d FromH(const Eigen::Vector3d& h) {
  return {h.x(), h.z(), -h.y()};
}
Eigen::Vector3d ToH(const Eigen::Vector3d& m) {
  return {m.x(), -m.z(), m.y()};
}

DeviceCapabilities CapabilitiesOf(bool has_grip) {
  DeviceCapabilities own;
  own.sensed_dof = has_grip ? 6 : 3;
  own.actuated_dof = 3;
  own.force = kForce;
  own.rate = kRate;
  return own;
}

// The first state of a connection. Services that do not send it unrequested are queried.
bool ReceiveFirst(HaplyLine* line, std::string* text) {
  const auto first = line->Receive(kOpenWithin, text);
  if (first != HaplyLine::Received::kNothingYet) return first == HaplyLine::Received::kMessage;
  return line->Send(HaplyStateRequest(), kWait) &&
         line->Receive(kOpenWithin, text) == HaplyLine::Received::kMessage;
}

std::string Described(const std::string& release, const HaplyState& state,
                      const std::optional<HaplySessions>& sessions) {
  std::string words = "haply: Inverse3 " + Presentable(state.id, 20) + ", service ";
  words += release.empty() ? "of unknown release" : release;
  words += state.has_grip ? ", with VerseGrip" : ", without VerseGrip (no switch to engage)";
  if (state.gate_gain && *state.gate_gain != 1) {
    words += Formatted(", force gate %g", *state.gate_gain);
  }
  if (!sessions) return words;
  if (sessions->force_scale != 1) words += Formatted(", force scale %g", sessions->force_scale);
  const std::size_t others = sessions->count - std::min<std::size_t>(sessions->count, 1);
  if (others > 0) words += ", " + std::to_string(others) + " other sessions may add forces";
  return words;
}

}  // namespace

HaplyDevice::Opened HaplyDevice::OpenLine(const Options& options) {
  Opened opened;
  opened.line = std::make_unique<HaplyLine>(options.port);
  const std::string at = " at 127.0.0.1:" + std::to_string(options.port);
  const std::string version = opened.line->Get("/version", kOpenWithin).value_or("");
  opened.form = HaplyFormOf(version);
  if (!opened.line->Open(kOpenWithin)) {
    throw DeviceUnavailable("haply", "no haply-inverse-service answers" + at);
  }
  std::string text;
  if (!ReceiveFirst(opened.line.get(), &text)) {
    throw DeviceUnavailable("haply", "the service sends no state" + at);
  }
  const auto state = ParseHaplyState(text);
  if (!state) throw DeviceUnavailable("haply", "the service sends a state of unknown form");
  if (state->id.empty())
    throw DeviceUnavailable("haply", "no Inverse3 is connected to the service");
  opened.first = *state;
  const auto sessions = opened.line->Get("/sessions", kOpenWithin);
  opened.description =
      Described(HaplyRelease(version), *state,
                sessions ? ParseHaplySessions(*sessions) : std::optional<HaplySessions>());
  return opened;
}

std::unique_ptr<HaplyDevice> HaplyDevice::Open(const Options& options) {
  return std::unique_ptr<HaplyDevice>(new HaplyDevice(OpenLine(options), options));
}

HaplyDevice::HaplyDevice(Opened opened, const Options& options)
    : HapticDevice(CapabilitiesOf(opened.first.has_grip)),
      line_(std::move(opened.line)),
      form_(opened.form),
      description_(std::move(opened.description)),
      clock_(options.clock),
      id_(opened.first.id) {
  newest_.repeated = true;
  Publish(opened.first);
  thread_ = std::jthread([this](const std::stop_token& stop) { Work(stop); });
}

HaplyDevice::~HaplyDevice() {
  thread_.request_stop();
  thread_.join();
  line_->Send(HaplyForceMessage(id_, Eigen::Vector3d::Zero(), form_), kWait);
}

void HaplyDevice::Work(const std::stop_token& stop) {
  MakeThreadRealtime(kLinkPriority);
  while (!stop.stop_requested()) {
    auto next = std::chrono::steady_clock::now();
    while (!stop.stop_requested() && Exchange(stop)) {
      next = std::max(next + kExchangePeriod, std::chrono::steady_clock::now());
      std::this_thread::sleep_until(next);
    }
    if (stop.stop_requested()) return;
    sent_.setZero();
    PublishFault("the connection to haply-inverse-service is lost");
    std::string inventory;
    if (!line_->Open(kOpenWithin) || !ReceiveFirst(line_.get(), &inventory)) {
      std::this_thread::sleep_for(kRetryEvery);
    }
  }
}

bool HaplyDevice::Exchange(const std::stop_token& stop) {
  if (const Command* newest = commands_.Take()) command_ = *newest;
  const bool is_new = SecondsBetween(command_.at, clock_()) < kLetGoAfter;
  sent_ = is_new ? command_.force : Eigen::Vector3d(0, 0, 0);
  if (!line_->Send(HaplyForceMessage(id_, ToH(sent_), form_), kWait)) return false;
  std::string text;
  for (int i = 0; i < kMaxWaits && !stop.stop_requested(); ++i) {
    const auto received = line_->Receive(kWait, &text);
    if (received == HaplyLine::Received::kClosed) return false;
    if (received == HaplyLine::Received::kNothingYet) continue;
    const auto state = ParseHaplyState(text);
    if (!state) {
      PublishFault("the service sends a state of unknown form");
    } else if (state->id != id_) {
      PublishFault("the Inverse3 is not connected to the service");
    } else {
      Publish(*state);
    }
    return true;
  }
  return stop.stop_requested();
}

float HaplyDevice::ForceShare(const HaplyState& state) const {
  const double size = sent_.norm();
  if (!state.force || size < kMinCompared) return NAN;
  return static_cast<float>(FromH(*state.force).dot(sent_) / (size * size));
}

void HaplyDevice::Publish(const HaplyState& state) {
  DeviceReading reading;
  reading.at = clock_();
  reading.p_M = FromH(state.position);
  if (state.velocity) {
    reading.v_M = FromH(*state.velocity);
  } else if (last_.at != Time{} && reading.at > last_.at) {
    const double dt = SecondsBetween(last_.at, reading.at);
    const Eigen::Vector3d v = (reading.p_M - last_.p_M) / dt;
    reading.v_M = last_.v_M + std::min(1.0, dt / kSmooth) * (v - last_.v_M);
  }
  if (state.orientation) {
    const Eigen::Quaterniond& q = *state.orientation;
    const Eigen::Vector3d axis = FromH(q.vec());
    reading.q_M = Eigen::Quaterniond(q.w(), axis.x(), axis.y(), axis.z());
  }
  reading.status.buttons = state.buttons;
  reading.engaged = (state.buttons & 1U) != 0;
  reading.status.calibration =
      state.calibrated ? CalibrationState::kCalibrated : CalibrationState::kManual;
  reading.status.force_share = ForceShare(state);
  last_ = reading;
  readings_.Put(reading);
}

void HaplyDevice::PublishFault(const char* cause) {
  DeviceReading reading = last_;
  reading.engaged = false;
  reading.status.fault = DeviceFault::kUnplugged;
  reading.status.cause = cause;
  readings_.Put(reading);
}

DeviceReading HaplyDevice::DoRead(Time now) noexcept {
  read_at_ = now;
  const DeviceReading* newest = readings_.Take();
  if (newest != nullptr) newest_ = *newest;
  newest_.repeated = newest == nullptr;
  return newest_;
}

DeviceOutput HaplyDevice::DoWrite(const Wrench& wrench) noexcept {
  commands_.Put({wrench.force, read_at_});
  constexpr float kAsWritten = 0.95F;
  const float share = newest_.status.force_share;
  return share < kAsWritten ? DeviceOutput::kSaturated : DeviceOutput::kOk;
}

Driver HaplyDriver() {
  return {"haply", "Haply Inverse3 with VerseGrip (haply-inverse-service)",
          "port of the service, 10001 by default",
          [] {
            DriverReport report;
            report.searched.emplace_back("haply-inverse-service at 127.0.0.1:10001");
            AddOpened(HaplyDriver(), &report);
            if (!report.usable && report.next.empty()) {
              report.next =
                  "install and start the Haply Inverse service, connect the Inverse3, and "
                  "wake the VerseGrip";
            }
            return report;
          },
          [](const std::string& option) -> std::unique_ptr<HapticDevice> {
            HaplyDevice::Options options;
            if (!option.empty()) {
              const auto port = ParseFinite(option);
              if (!port || *port < 1 || *port > 65535 || *port != std::floor(*port)) {
                throw std::invalid_argument("--device haply:" + option +
                                            ": expected a port, 1 to 65535");
              }
              options.port = static_cast<std::uint16_t>(*port);
            }
            return HaplyDevice::Open(options);
          }};
}

}  // namespace palpate
