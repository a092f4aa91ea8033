#include "master/station/terminal_text.h"

#include <algorithm>
#include <cmath>

#include "master/station/alarms.h"
#include "master/view/console.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kMilli = 1e3;
constexpr int kBar = 30;  // characters
constexpr std::size_t kSayingsShown = 6;
constexpr const char* kKeys =
    "Space STOP  r reset  c clutch  m mark  n tare  v rendering  b record  q quit";

enum class Tone { kPlain, kGood, kNote, kBad };

std::string Or(bool known, const char* format, double value) {
  return known ? Formatted(format, value) : "-";
}

Tone ToneOf(OperatorState state) {
  switch (state) {
    case OperatorState::kFollowing:
      return Tone::kGood;
    case OperatorState::kHold:
      return Tone::kNote;
    case OperatorState::kDisconnected:
    case OperatorState::kEstop:
      return Tone::kBad;
    default:
      return Tone::kPlain;
  }
}

class Sheet {
 public:
  explicit Sheet(const TerminalLook& look) : look_(look) {}

  void Add(const std::string& line, Tone tone = Tone::kPlain) {
    constexpr const char* kColours[] = {"", "\x1b[32m", "\x1b[33m", "\x1b[1;31m"};
    const auto width = static_cast<std::size_t>(std::max(20, look_.columns));
    std::string cut = Presentable(line, width);
    const bool is_coloured = look_.colour && tone != Tone::kPlain;
    if (is_coloured) cut = kColours[static_cast<int>(tone)] + cut + "\x1b[0m";
    lines_.push_back(std::move(cut));
  }
  // Adds the line of keys as the last one; other lines are cut if there is no room.
  std::vector<std::string> Finish() {
    const auto rows = static_cast<std::size_t>(std::max(2, look_.rows));
    if (lines_.size() >= rows) lines_.resize(rows - 1);
    Add(kKeys);
    return std::move(lines_);
  }

 private:
  const TerminalLook look_;
  std::vector<std::string> lines_;
};

std::string Bar(double force, double limit) {
  const double share = limit > 0 ? std::clamp(force / limit, 0.0, 1.0) : 0;
  const auto full = static_cast<std::size_t>(std::lround(share * kBar));
  return "[" + std::string(full, '#') + std::string(kBar - full, '.') + "]";
}

void AddHead(const StationHello& hello, const StationMoment& moment, Sheet* sheet) {
  const TickRecord& tick = moment.ticks.newest;
  sheet->Add("palpate " + hello.badge + "  " + hello.scene.name + "  " + hello.scene.model +
             "  slave " + hello.target + (hello.encrypted ? " (TLS)" : " (plain text)"));
  sheet->Add(Formatted("%-12s  %8.1f s  epoch %u%s", std::string(ToString(tick.state)).c_str(),
                       moment.ticks.t, tick.epoch, tick.clutched ? "  CLUTCH OPEN (c)" : ""),
             ToneOf(tick.state));
  const LineState line = LineOf(moment);
  std::string words = "link   " + std::string(line.word);
  if (!line.why.empty()) words += ": " + line.why;
  if (!line.role.empty() && !moment.replay) words += "  as " + std::string(line.role);
  sheet->Add(words, line.word == "good" ? Tone::kPlain : Tone::kNote);
}

void AddForce(const StationMoment& moment, Sheet* sheet) {
  const ForceChain& chain = moment.ticks.newest.chain;
  const SlaveState& felt = moment.felt.state;
  const double sent = chain.sent.norm(), limit = moment.status.force_limit;
  double peak = sent;
  for (const TickSample& sample : moment.ticks.samples) peak = std::max(peak, sample.sent);
  sheet->Add(Formatted("force  %6.2f N of %.2f N ", sent, limit) + Bar(sent, limit) +
             Formatted("  peak %.2f N", peak));
  const bool known = felt.sequence > 0;
  const std::string check(known ? ToString(felt.check) : "");
  sheet->Add("slave  " + Or(chain.force_known, "%.3f N", chain.estimated.norm()) + "  sigma " +
                 Or(known && chain.force_known, "%.3f N", felt.sigma) + "  " +
                 std::string(known ? ToString(felt.validity) : "not received yet") +
                 (check.empty() ? "" : " (" + check + ")"),
             known && felt.validity != Validity::kValid ? Tone::kNote : Tone::kPlain);
  sheet->Add(Formatted("chain  local %.3f  scaled %.3f  passive %.3f  limited %.3f  sent %.3f N",
                       chain.local.norm(), chain.scaled.norm(), chain.passive.norm(),
                       chain.limited.norm(), sent));
  const std::string reasons = InWords(chain.reasons);
  sheet->Add("       " + (reasons.empty() ? "as estimated by the slave" : "changed by " + reasons));
}

// The device by its name alone, and its state.
void AddDevice(const StationHello& hello, const StationMoment& moment, Sheet* sheet) {
  const DeviceStatus& device = moment.ticks.newest.device;
  const std::string fault = FaultInWords(device);
  const std::string name = hello.device.substr(0, hello.device.find(':'));
  if (!moment.replay) {
    sheet->Add("device " + name + "  " + (fault.empty() ? InWords(device) : fault),
               fault.empty() ? Tone::kPlain : Tone::kBad);
  }
}

void AddLine(const StationMoment& moment, Sheet* sheet) {
  const TickRecord& tick = moment.ticks.newest;
  const LinkStats& link = moment.status.link;
  sheet->Add("timing round trip " +
             Or(moment.ticks.round_trip > 0, "%.2f ms", kMilli * moment.ticks.round_trip) +
             "  99 % " + Or(link.rtt_p99_us > 0, "%.2f ms", link.rtt_p99_us / kMilli) + "  age " +
             Or(tick.state_age >= 0, "%.0f ms", kMilli * std::clamp(tick.state_age, 0.0, 99.0)) +
             Formatted("  late %.1f %%  reconnects %llu", 100 * moment.ticks.late_share,
                       static_cast<unsigned long long>(link.reconnects)));
  std::string loop =
      "loop   " + Or(moment.ticks.rate > 0, "%.0f Hz", moment.ticks.rate) +
      Formatted("  missed %llu  rendering ", static_cast<unsigned long long>(moment.ticks.missed)) +
      std::string(ToString(tick.render)) + Formatted("  marks %u", tick.marks);
  if (moment.recording) {
    loop += moment.recording->on ? Formatted("  REC %.1f MB", moment.recording->megabytes)
                                 : "  not recording";
  }
  sheet->Add(loop);
}

void AddAlarms(const StationMoment& moment, Sheet* sheet) {
  const std::vector<Alarm> alarms = AlarmsOf(moment);
  if (alarms.empty()) sheet->Add("good:  no alarm", Tone::kGood);
  for (const Alarm& alarm : alarms) {
    const bool is_bad = alarm.level == Alarm::Level::kStop;
    sheet->Add((is_bad ? "STOP:  " : "note:  ") + alarm.text, is_bad ? Tone::kBad : Tone::kNote);
    if (!alarm.next.empty()) sheet->Add("       " + alarm.next);
  }
}

RenderMode NextMode(RenderMode mode) {
  return static_cast<RenderMode>((static_cast<int>(mode) + 1) % kRenderModes);
}

}  // namespace

std::vector<std::string> TerminalText(const StationHello& hello, const StationMoment& moment,
                                      const std::vector<LogEntry>& said, const TerminalLook& look) {
  Sheet sheet(look);
  AddHead(hello, moment, &sheet);
  AddForce(moment, &sheet);
  for (const std::string& line : FingerTable(moment.status.fingers, nullptr)) sheet.Add(line);
  AddLine(moment, &sheet);
  AddDevice(hello, moment, &sheet);
  AddAlarms(moment, &sheet);
  const std::size_t skipped = said.size() - std::min(said.size(), kSayingsShown);
  for (auto saying = said.begin() + static_cast<std::ptrdiff_t>(skipped); saying != said.end();
       ++saying) {
    sheet.Add(Formatted("%8.1f s  ", saying->t) + saying->text);
  }
  return sheet.Finish();
}

std::optional<PageCommand> CommandOfKey(char key, const StationMoment& moment) {
  const TickRecord& tick = moment.ticks.newest;
  switch (key) {
    case kQuitKey:
      return std::nullopt;
    case 'r':
      return ResetCommand{};
    case 'c':
      return ClutchCommand{!tick.clutched};
    case 'm':
      return MarkCommand{};
    case 'n':
      return TareCommand{};
    case 'v':
      return RenderCommand{NextMode(tick.render)};
    case 'b':
      return RecordCommand{!(moment.recording && moment.recording->on)};
    default:
      return StopCommand{};
  }
}

}  // namespace palpate
