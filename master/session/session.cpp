#include "master/session/session.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>
#include <thread>

#include <nlohmann/json.hpp>

#include "master/haptics/stable_stiffness.h"
#include "shared/link/thread_priority.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using Json = nlohmann::ordered_json;

// Rounds to six digits.
double Tidy(double value) {
  if (!std::isfinite(value)) return 0;
  if (value == 0) return 0;
  const double scale = std::pow(10.0, 5 - std::floor(std::log10(std::abs(value))));
  const double tidy = std::round(value * scale) / scale;
  return std::isfinite(tidy) ? tidy : value;
}

Json Times(const LatencyHistogram& times) {
  return {{"p50", Tidy(times.Quantile(0.5))},
          {"p99", Tidy(times.Quantile(0.99))},
          {"p999", Tidy(times.Quantile(0.999))},
          {"max", Tidy(times.max())}};
}

Json Times(const LinkStats::Times& times) {
  return {{"p50", Tidy(times.p50_us)}, {"p99", Tidy(times.p99_us)}, {"max", Tidy(times.max_us)}};
}

Json ErrorOf(const ForceError::Summary& error, double force_peak) {
  Json json{
      {"rms_N", Tidy(error.rms)}, {"peak_N", Tidy(error.peak)}, {"contact_ticks", error.ticks}};
  json["relative_rms"] = force_peak > 0 ? Json(Tidy(error.rms / force_peak)) : Json();
  return json;
}

Json ErrorOf(const Report& report) {
  if (!report.force_error) return nullptr;
  Json json = ErrorOf(*report.force_error, report.force_peak);
  json["let_go_ticks"] = report.let_go_ticks;
  return json;
}

Json DelayCompensatedErrorOf(const Report& report) {
  if (!report.force_error_delay_compensated) return nullptr;
  Json json = ErrorOf(report.force_error_delay_compensated->later, report.force_peak);
  json["first_contact"] = ErrorOf(report.force_error_delay_compensated->first, report.force_peak);
  return json;
}

Json BreakingOf(const Report& report) {
  if (!report.breaking) return nullptr;
  Json json = ErrorOf(report.breaking->error, report.force_peak);
  json["punctures"] = report.breaking->punctures;
  json["longest_ticks"] = report.breaking->longest;
  return json;
}

Json FingersOf(const Report& report) {
  Json fingers = Json::array();
  for (const FingerReport& finger : report.fingers) {
    fingers.push_back({{"name", finger.name},
                       {"contact_share", Tidy(finger.contact_share)},
                       {"force_peak_N", Tidy(finger.force_peak)}});
  }
  return fingers;
}

constexpr const char* kUnanswered = "the slave has not answered the emergency stop";
constexpr std::size_t kRingCapacity = 4096;  // four seconds of ticks
constexpr double kForever = 1e9;             // [s]
constexpr double kShowEvery = 0.1;           // [s]
constexpr std::chrono::milliseconds kPollPeriod{10};

std::string Join(const std::string& a, const std::string& b) {
  return a.empty() || b.empty() ? a + b : a + "; " + b;
}

// Rate over about the last second, from the number of records.
class RateMeter {
 public:
  double Update(double t, std::uint64_t ticks) {
    if (t - t_ >= 0.5) {
      rate_ = static_cast<double>(ticks - ticks_) / (t - t_);
      t_ = t;
      ticks_ = ticks;
    }
    return rate_;
  }

 private:
  double t_ = 0, rate_ = 0;
  std::uint64_t ticks_ = 0;
};

// Returns the state after disengaging at the end of a run. A state that could continue becomes
// READY.
OperatorState AfterLettingGo(OperatorState state) {
  const bool could_go_on = state == OperatorState::kAligning ||
                           state == OperatorState::kFollowing || state == OperatorState::kClutched;
  return could_go_on ? OperatorState::kReady : state;
}

std::string NameOf(std::size_t finger, const std::vector<std::string>& names) {
  if (finger < names.size() && !names[finger].empty()) return names[finger];
  return "finger " + std::to_string(finger + 1);
}

void AddFingers(const TickSummary& summary, const std::vector<std::string>& names, Report* report) {
  const auto fingers = summary.fingers();
  if (fingers.size() < 2) return;
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    report->fingers.push_back(
        {NameOf(i, names), fingers[i].contact_share(), fingers[i].force_peak});
  }
}

void AddSummary(const TickSummary& summary, double duration, Report* report) {
  report->force_peak = summary.force_peak();
  report->force_error = summary.force_error();
  report->let_go_ticks = summary.let_go_ticks();
  report->force_error_delay_compensated = summary.force_error_delay_compensated();
  report->breaking = summary.breaking();
  report->truth_known = summary.has_truth();
  report->force_sent_peak = summary.sent_peak();
  report->clamped_ticks = summary.ticks(Reason::kClamped);
  report->stale_ticks = summary.stale_ticks();
  report->epochs = summary.epochs();
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    const auto reason = static_cast<Reason>(i);
    if (summary.ticks(reason) > 0) {
      report->reasons[std::string(ToString(reason))] = summary.ticks(reason);
    }
  }
  std::uint64_t all = 0;
  for (std::size_t i = 0; i < kOperatorStateCount; ++i) {
    all += summary.ticks(static_cast<OperatorState>(i));
  }
  for (std::size_t i = 0; i < kOperatorStateCount; ++i) {
    const auto state = static_cast<OperatorState>(i);
    if (summary.ticks(state) == 0) continue;
    const double share = static_cast<double>(summary.ticks(state)) / static_cast<double>(all);
    report->seconds_in[std::string(ToString(state))] = share * duration;
  }
}

}  // namespace

std::vector<NamedFinger> Named(const TickRecord& record, const std::vector<std::string>& names) {
  std::vector<NamedFinger> fingers(static_cast<std::size_t>(record.finger_count));
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    fingers[i] = {fingers.size() == 1 && names.empty() ? "tool" : NameOf(i, names),
                  record.fingers[i]};
  }
  return fingers;
}

std::string ToJson(const Report& report) {
  Json json;
  json["duration_s"] = Tidy(report.duration);
  json["ticks"] = report.ticks;
  json["missed"] = report.missed;
  json["rate_hz"] = Tidy(report.rate());
  json["wake_us"] = Times(report.wake_us);
  json["compute_us"] = Times(report.compute_us);
  json["rtt_us"] = {{"p50", Tidy(report.link.rtt_p50_us)},
                    {"p99", Tidy(report.link.rtt_p99_us)},
                    {"max", Tidy(report.link.rtt_max_us)}};
  json["state_delay_us"] = Times(report.link.delay);
  json["state_age_us"] = Times(report.link.age);
  json["command_age_us"] = Times(report.link.command_age);
  json["states"] = report.link.states;
  json["states_by_datagram"] = report.link.states_by_datagram;
  json["reconnects"] = report.link.reconnects;
  json["force_peak_N"] = Tidy(report.force_peak);
  json["force_peak_is"] = report.truth_known ? "true" : "estimated";
  json["force_sent_peak_N"] = Tidy(report.force_sent_peak);
  json["force_error"] = ErrorOf(report);
  json["force_error_delay_compensated"] = DelayCompensatedErrorOf(report);
  json["breaking"] = BreakingOf(report);
  if (!report.fingers.empty()) json["fingers"] = FingersOf(report);
  if (report.shape) {
    json["shape"] = {{"meshes", report.shape->meshes},
                     {"deflection_peak_m", Tidy(report.shape->deflection_peak)}};
  }
  json["patch"] = {{"patches", report.patch.patches},
                   {"laws", report.patch.laws},
                   {"refused", report.patch.refused},
                   {"bytes", report.patch.bytes}};
  json["energy_min_J"] = Tidy(report.energy_min);
  json["work_min_J"] = Tidy(report.work_min);
  json["clamped_ticks"] = report.clamped_ticks;
  json["stale_ticks"] = report.stale_ticks;
  json["state"] = ToString(report.state);
  json["render"] = report.render;
  json["epochs"] = report.epochs;
  json["commands"] = report.link.commands;
  json["clock_offset_s"] = Tidy(report.link.clock_offset);
  json["seconds_in"] = report.seconds_in;
  json["reasons"] = report.reasons;
  json["records_dropped"] = report.records_dropped;
  json["scene"] = report.scene;
  json["model"] = report.model;
  json["device"] = report.device;
  json["realtime"] = report.realtime;
  json["trouble"] = report.trouble;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

void WriteReport(const Report& report, const std::filesystem::path& file) {
  ReplaceFile(file, ToJson(report));
}

Report RunSession(const SessionOptions& options, Device& device, LatestValue<ReceivedState>* states,
                  LatestValue<OperatorCommand>* commands, const std::function<LinkStats()>& link,
                  const std::function<bool()>& stop_wanted,
                  const std::function<void(const SessionStatus&)>& show) {
  SpscRing<TickRecord> ring(kRingCapacity);
  HapticLoop::Options limited = options.loop;
  device.LowerForceLimit(limited.force_limit);
  const DeviceLimits bounds = device.limits();
  limited.force_limit = std::min(limited.force_limit, bounds.force);
  const RenderedRate rate{bounds.stiffness, bounds.rate, options.sensor_rate};
  limited.stiffest = std::min(limited.stiffest, StableStiffness(RenderMode::kLocal, rate, 0));
  limited.max_damping = std::min(limited.max_damping, bounds.damping);
  limited.slew_limit = std::min(limited.slew_limit, bounds.slew);
  limited.sends_orientation = bounds.senses_orientation;
  limited.renders_torque = bounds.torque > 0;
  HapticLoop loop(limited,
                  {states, commands, &ring, options.settings, options.patches, options.requests});

  StiffnessNotice stiffness(rate, loop.motion().contact_stiffness());
  Recorder recorder(&ring, options.log, [&](const TickRecord& tick) {
    const std::string notice = stiffness.Check(tick);
    if (!notice.empty() && options.notify) options.notify(notice);
    if (options.on_tick) options.on_tick(tick);
  });

  Report report;
  report.realtime = LockMemory();
  const Time begin = Clock::now();
  const auto length = Seconds(options.duration > 0 ? options.duration : kForever);
  std::atomic<bool> done{false};
  std::string refused;  // read after the join
  std::jthread haptic([&](const std::stop_token& stop) {
    refused = MakeThreadRealtime(kHapticPriority);
    loop.Run(device, length, stop);
    done = true;
  });

  std::optional<StopPath> emergency(std::in_place, loop.stops(), options.emergency);
  RateMeter meter;
  double shown = -1;
  while (!done) {
    std::this_thread::sleep_for(kPollPeriod);
    if (stop_wanted()) haptic.request_stop();
    recorder.Drain(Clock::now());
    const double t = SecondsBetween(begin, Clock::now());
    if (t - shown < kShowEvery || recorder.newest().at == Time{}) continue;
    shown = t;
    LinkStats link_stats = link();
    if (loop.stops().is_wanted()) link_stats.trouble = Join(kUnanswered, link_stats.trouble);
    SessionStatus status{t,
                         recorder.newest(),
                         meter.Update(t, recorder.taken()),
                         recorder.newest().force_limit,
                         Named(recorder.newest(), options.finger_names),
                         link_stats};
    status.device = device.description();
    show(status);
  }
  haptic.join();
  emergency.reset();
  recorder.Finish();

  report.realtime = Join(refused, report.realtime);
  report.device = device.description();
  report.render = ToString(options.loop.render);
  report.duration = loop.stats().periodic.duration;
  report.ticks = loop.stats().periodic.ticks;
  report.missed = loop.stats().periodic.missed;
  report.wake_us = loop.stats().periodic.wake_us;
  report.compute_us = loop.stats().compute_us;
  report.link = link();
  if (options.patch_stats) report.patch = options.patch_stats();
  report.energy_min = loop.passivity().min_balance();
  report.work_min = loop.passivity().min_work();
  report.records_dropped = ring.dropped();
  report.state = AfterLettingGo(loop.record().state);
  AddSummary(recorder.summary(), report.duration, &report);
  AddFingers(recorder.summary(), options.finger_names, &report);
  report.log_failed = !recorder.trouble().empty();
  if (report.log_failed) report.trouble.push_back(recorder.trouble());
  if (!report.link.trouble.empty()) report.trouble.push_back(report.link.trouble);
  if (loop.stops().is_wanted()) report.trouble.emplace_back(kUnanswered);
  return report;
}

}  // namespace palpate
