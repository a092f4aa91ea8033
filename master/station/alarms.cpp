#include "master/station/alarms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "master/station/moment_json.h"
#include "shared/text/text.h"
#include "shared/wire/enum_names.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

constexpr double kLate = 0.030;      // [s]
constexpr double kLateShare = 0.01;  // [-]
constexpr double kSlowLoop = 900;    // [Hz]
constexpr double kNearLimit = 0.8;   // [-]
constexpr double kLittleRoom = 200;  // free disk space for about ten minutes of a recording [MB]
constexpr double kClocksApart = 60;  // [s]
constexpr const char* kSameRelease =
    "Features that only one of them has are off. Install the same release at both ends.";
constexpr const char* kOtherBuild = "Data that only the other release has are not shown.";

std::string Spaced(std::string_view code) {
  std::string words(code);
  std::ranges::replace(words, '_', ' ');
  return words;
}

class Alarms {
 public:
  explicit Alarms(const StationMoment& moment) : moment_(moment), tick_(moment.ticks.newest) {}

  std::vector<Alarm> List() {
    AddStop();
    AddDevice();
    AddLine();
    const LinkStats& link = moment_.status.link;
    if (link.connected || link.observes) AddValidity();
    if (link.connected) {
      AddReasons();
      AddLimit();
    }
    // Without a connection these would only repeat the cause.
    if (link.connected || link.answers) AddNews();
    AddRest();
    return std::move(list_);
  }

 private:
  void Stop(std::string text, std::string next) {
    list_.push_back({Alarm::Level::kStop, std::move(text), std::move(next)});
  }
  void Note(std::string text, std::string next = {}) {
    list_.push_back({Alarm::Level::kNote, std::move(text), std::move(next)});
  }

  void AddStop() {
    if (tick_.state == OperatorState::kStopRequested) {
      return Stop(
          "Emergency stop requested: the slave has not confirmed it, the tool may still move.",
          "Use the emergency stop of the manipulator if it moves.");
    }
    if (tick_.state != OperatorState::kEstop) return;
    Stop("Emergency stop: the tool is stopped, the operator is disengaged.",
         "When it is safe, press R or the button beside STOP, then engage again.");
  }
  void AddDevice() {
    constexpr float kWhole = 0.95F;
    const DeviceStatus& device = tick_.device;
    const std::string name =
        moment_.status.device.empty() ? "The device" : "The device (" + moment_.status.device + ")";
    if (device.fault != DeviceFault::kNone) {
      Stop(name + ": " + FaultInWords(device) + ". Its force is zero.",
           std::string(NextStepOf(device.fault)));
    } else if (device.force_share < kWhole) {
      Note(Formatted("%s renders %.0f %% of the force.", name.c_str(),
                     100 * static_cast<double>(device.force_share)),
           "Look for a force gate or a force scale of the device, and for other programs that use "
           "it.");
    }
  }
  void AddLine() {
    const LinkStats& link = moment_.status.link;
    const std::string why = link.trouble.empty() ? "" : ": " + link.trouble;
    if (link.observes) return;  // an observer cannot move anything, which the page shows
    if (!link.connected) {
      Stop("No link to the slave" + why + ".",
           link.answers
               ? "The slave answers and states the reason: correct it. The master retries by "
                 "itself; then engage again."
               : "Is palpate-slave running? The master retries by itself; engage again "
                 "when the slave is back.");
    } else if (!why.empty()) {
      Note("The link to the slave" + why + ".", "If this persists, restart palpate-master.");
    } else if (tick_.state_age > kLate) {
      Stop("No state from the slave for more than 30 ms.",
           "The tool is stopped. Wait, or check the network.");
    }
  }
  void AddValidity();
  void AddReasons();
  void AddLimit() {
    const double limit = moment_.status.force_limit;
    if (tick_.chain.reasons.Has(Reason::kClamped)) return;
    if (limit > 0 && tick_.chain.sent.norm() > kNearLimit * limit) {
      Note("The force exceeds 80 % of the force limit.", "Do not press deeper.");
    }
  }
  void AddNews() {
    if (moment_.ticks.late_share > kLateShare) {
      Note(Formatted("States came late in %.0f %% of the last 10 s.",
                     100 * moment_.ticks.late_share),
           "The link is slow or the machine is busy: see the charts.");
    }
    AddFrozenImage();
    for (const std::string& text : moment_.slave_alarms) Note("The slave reports: " + text + ".");
    if (!moment_.health_trouble.empty()) {
      Note("The slave does not report its status: " + moment_.health_trouble + ".",
           "The link is slow or the slave is busy. The force is independent of it.");
    }
  }
  void AddFrozenImage() {
    const v1::SlaveState& state = moment_.slave_state;
    const bool sets_up = state.phase() == v1::PHASE_SETUP;
    const bool is_known = state.validity() == v1::VALIDITY_STALE && !sets_up;
    if (!(moment_.frozen_for > 0) || is_known) return;
    Note(Formatted("The image has been frozen for %.0f s.", moment_.frozen_for),
         sets_up ? "Check the camera, its driver and its cable."
                 : "The force is independent of it: check its age. If this persists, reload the "
                   "page.");
  }
  void AddRest() {
    if (!moment_.other_release.empty()) {
      Note(moment_.other_release, moment_.replay ? kOtherBuild : kSameRelease);
    }
    if (moment_.recording) AddRecording(*moment_.recording);
    if (const double apart = moment_.status.link.clock_offset; std::abs(apart) > kClocksApart) {
      Note(Formatted("The slave's clock differs by %+.0f s.", apart),
           "This affects times in logs and certificates, not the force. Run NTP at both ends.");
    }
  }
  void AddRecording(const RecordingMoment& recording) {
    if (!recording.trouble.empty()) {
      Note("The recording: " + recording.trouble + ".",
           recording.falls_behind ? "Stop other programs on the master's machine, or record to a "
                                    "faster disk. If it falls further behind, it ends."
                                  : "Free disk space, or raise --record-limit at the next start.");
    } else if (recording.on && recording.room && *recording.room < kLittleRoom) {
      Note(Formatted("The recording: %.0f MB are left on its disk.", *recording.room),
           "Free disk space now. A full disk ends the recording, not the session.");
    }
  }

  const StationMoment& moment_;
  const TickRecord& tick_;
  std::vector<Alarm> list_;
};

std::string NextFor(v1::Validity validity) {
  switch (validity) {
    case v1::VALIDITY_TRACKING_LOST:
      return "Check the image: the tool must be visible. Move it into view, then engage again.";
    case v1::VALIDITY_EXTRAPOLATED:
      return "Press less deeply, or look up the check in slave/CHECKS.md.";
    case v1::VALIDITY_STALE:
      return "Check that camera or fingertips still send data: Setup shows what is missing.";
    case v1::VALIDITY_PUNCTURED:
      return "Retract the tool.";
    default:
      return "See the slave's log: it states why the model has no solution.";
  }
}

void Alarms::AddValidity() {
  const v1::SlaveState& state = moment_.slave_state;
  // Unknown values of newer slaves become the safest known value.
  const v1::Validity validity = ToProto(FromProto(state.validity()));
  const v1::FailedCheck check = ToProto(FromProto(state.check()));
  if (state.sequence() == 0 || validity == v1::VALIDITY_VALID) return;
  if (state.phase() == v1::PHASE_SETUP) return;  // there is no scene yet
  const bool is_shown_by_link = validity == v1::VALIDITY_STALE && tick_.state_age > kLate;
  if (is_shown_by_link) return;
  const std::string text =
      "The force is " + Spaced(ProtoNameOf(validity)) +
      (check == v1::FAILED_CHECK_UNSPECIFIED ? ""
                                             : " (check: " + Spaced(ProtoNameOf(check)) + ")") +
      ".";
  const bool is_note = validity == v1::VALIDITY_EXTRAPOLATED || validity == v1::VALIDITY_PUNCTURED;
  is_note ? Note(text, NextFor(validity)) : Stop(text, NextFor(validity));
}

void Alarms::AddReasons() {
  struct Change {
    Reason reason;
    const char *words, *next;
  };
  constexpr std::array<Change, 7> kChanges{{
      {Reason::kClamped, "the force limit", "Press less: a larger force cannot be rendered."},
      {Reason::kPassivity, "damped by passivity control",
       "It ends by itself. Slower motion and a faster link need less damping."},
      {Reason::kOffsetJump, "the slave moved the position offset", "Disengage, then engage again."},
      {Reason::kSettings, "the settings are being read", "It ends when they are read."},
      {Reason::kBadState, "a state with impossible numbers", "Check the slave's log and release."},
      {Reason::kBadDevice, "a device reading with impossible numbers",
       "Disengage, check the cable of the device, then engage again."},
      {Reason::kAged, "the sample is too old",
       "Check that camera or fingertips still send data: Setup shows what is missing."},
  }};
  for (const auto& [reason, words, next] : kChanges) {
    if (!tick_.chain.reasons.Has(reason)) continue;
    const bool is_reported =
        reason == Reason::kBadDevice && tick_.device.fault != DeviceFault::kNone;
    if (is_reported) continue;
    Note(std::string("The force was changed: ") + words + ".", next);
  }
}

}  // namespace

LineState LineOf(const StationMoment& moment) {
  const LinkStats& link = moment.status.link;
  const TickRecord& tick = moment.ticks.newest;
  if (!link.connected && !link.answers) return {"lost", {}, {}};
  if (!link.connected) return {"connected", {}, "observer"};
  if (tick.state == OperatorState::kDisconnected) return {"connected", {}, "operator"};
  std::string why;
  const auto add = [&why](const std::string& clause) { why += (why.empty() ? "" : "; ") + clause; };
  if (moment.ticks.late_share > kLateShare) {
    add(Formatted("%.0f %% of the states late", 100 * moment.ticks.late_share));
  }
  if (moment.ticks.rate > 0 && moment.ticks.rate < kSlowLoop) {
    add(Formatted("haptic loop at %.0f Hz", moment.ticks.rate));
  }
  if (!link.trouble.empty()) add(link.trouble);
  return {why.empty() ? "good" : "degraded", why, "operator"};
}

std::string_view ToString(Alarm::Level level) {
  return level == Alarm::Level::kStop ? "bad" : "warn";
}

std::vector<Alarm> AlarmsOf(const StationMoment& moment) {
  return Alarms(moment).List();
}

}  // namespace palpate
