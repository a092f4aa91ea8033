#include "master/station/alarms.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "master/station/moment_json.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kLate = 0.030;      // [s]
constexpr double kLateShare = 0.01;  // [-]
constexpr double kSlowLoop = 900;    // [Hz]
constexpr double kNearLimit = 0.8;   // [-]
constexpr double kLittleRoom = 200;  // ten minutes of a session [MB]
constexpr double kClocksApart = 60;  // [s]
constexpr const char* kSameRelease =
    "What only one of them knows is left out. Install the same release at both ends.";
constexpr const char* kOtherBuild = "What only that one knew is left out.";

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
    AddLine();
    if (moment_.status.link.connected) {  // else the rest of what comes from there only follows
      AddValidity();
      AddReasons();
      AddLimit();
      AddNews();
    }
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
    if (tick_.state != OperatorState::kEstop) return;
    Stop("Emergency stop: the tool stands, the hand is let go.",
         "When it is safe: R, or the button beside STOP, then engage again.");
  }
  void AddLine() {
    const LinkStats& link = moment_.status.link;
    const std::string why = link.trouble.empty() ? "" : ": " + link.trouble;
    if (!link.connected) {
      Stop("No line to the slave" + why + ".",
           link.answers ? "The slave is there and says what is wrong: mend that. The master tries "
                          "again by itself; then engage again."
                        : "Is palpate-slave running? The master tries again by itself; engage "
                          "again when it is back.");
    } else if (!why.empty()) {
      Note("The line to the slave" + why + ".", "If it stays, stop and start palpate-master.");
    } else if (tick_.state_age > kLate) {
      Stop("No state from the slave for more than 30 ms.",
           "The tool stands. Wait, or look at the network.");
    }
  }
  void AddValidity();
  void AddReasons();
  void AddLimit() {
    const double limit = moment_.status.force_limit;
    if (tick_.chain.reasons.Has(Reason::kClamped)) return;
    if (limit > 0 && tick_.chain.sent.norm() > kNearLimit * limit) {
      Note("More than four fifths of the force limit.", "Press no deeper.");
    }
  }
  void AddNews() {
    if (moment_.ticks.late_share > kLateShare) {
      Note(Formatted("States came late in %.0f %% of the last 10 s.",
                     100 * moment_.ticks.late_share),
           "A slower line or a busy machine: see the charts.");
    }
    if (moment_.picture_stands > 0 && moment_.felt.state.validity != Validity::kStale) {
      Note(Formatted("The picture has stood still for %.0f s.", moment_.picture_stands),
           "The force goes on beside it: its own age tells. If it stays, load the page again.");
    }
    for (const std::string& text : moment_.slave_alarms) Note("The slave says: " + text + ".");
    if (!moment_.health_trouble.empty()) {
      Note("The slave's health is not told: " + moment_.health_trouble + ".",
           "A slow line or a busy slave: the force goes on beside it.");
    }
  }
  void AddRest() {
    if (!moment_.other_release.empty()) {
      Note(moment_.other_release, moment_.replay ? kOtherBuild : kSameRelease);
    }
    if (moment_.recording) AddRecording(*moment_.recording);
    if (const double apart = moment_.status.link.clock_offset; std::abs(apart) > kClocksApart) {
      Note(Formatted("The slave's clock is %+.0f s from ours.", apart),
           "Times in logs and certificates go by it, no force does: run NTP at both ends.");
    }
  }
  void AddRecording(const RecordingMoment& recording) {
    if (!recording.trouble.empty()) {
      Note("The recording: " + recording.trouble + ".",
           "Make room, or give a larger --record-limit, at the next start.");
    } else if (recording.on && recording.room && *recording.room < kLittleRoom) {
      Note(Formatted("The recording: its disk has %.0f MB left.", *recording.room),
           "Make room now: a full disk ends the recording, not the hand.");
    }
  }

  const StationMoment& moment_;
  const TickRecord& tick_;
  std::vector<Alarm> list_;
};

std::string NextFor(Validity validity) {
  switch (validity) {
    case Validity::kTrackingLost:
      return "Look at the picture: is the tool in it, is it covered? Lift it clear, then engage "
             "again.";
    case Validity::kExtrapolated:
      return "Press less deep, or read CHECKS for the check that is named.";
    case Validity::kStale:
      return "See whether the camera or the fingertips still send: Setup names what they wait for.";
    case Validity::kPunctured:
      return "Draw the tool back.";
    default:
      return "See the slave's log: it says why the model has no answer.";
  }
}

void Alarms::AddValidity() {
  const SlaveState& felt = moment_.felt.state;
  if (felt.sequence == 0 || felt.validity == Validity::kValid) return;
  const bool line_says_so = felt.validity == Validity::kStale && tick_.state_age > kLate;
  if (line_says_so) return;
  const std::string check = Spaced(ToString(felt.check));
  const std::string text = "The force is " + Spaced(ToString(felt.validity)) +
                           (check.empty() ? "" : " (check: " + check + ")") + ".";
  const bool is_told =
      felt.validity == Validity::kExtrapolated || felt.validity == Validity::kPunctured;
  is_told ? Note(text, NextFor(felt.validity)) : Stop(text, NextFor(felt.validity));
}

void Alarms::AddReasons() {
  struct Change {
    Reason reason;
    const char *words, *next;
  };
  constexpr std::array<Change, 7> kChanges{{
      {Reason::kClamped, "the force limit", "Press less: more cannot be felt."},
      {Reason::kPassivity, "damped: no energy from nowhere",
       "It ends by itself; slower motion and a shorter line need less of it."},
      {Reason::kOffsetJump, "the slave moved the offset", "Let go, then engage again."},
      {Reason::kSettings, "settings are being read", "It ends when they are read."},
      {Reason::kBadState, "a state with impossible numbers",
       "See the slave's log, and its release."},
      {Reason::kBadDevice, "a device reading with impossible numbers",
       "Let go, see the device's cable, then engage again."},
      {Reason::kAged, "sensed too long ago",
       "See whether the camera or the fingertips still send: Setup names what they wait for."},
  }};
  for (const auto& [reason, words, next] : kChanges) {
    if (!tick_.chain.reasons.Has(reason)) continue;
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
    add(Formatted("the loop at %.0f Hz", moment.ticks.rate));
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
