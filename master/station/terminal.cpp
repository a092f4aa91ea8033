#include "master/station/terminal.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "master/station/alarms.h"
#include "master/view/console.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr int kPatience = 100;                         // period of the check whether to end [ms]
constexpr std::chrono::seconds kEvery(1);              // in a pipe
constexpr const char* kOpen = "\x1b[?1049h\x1b[?25l";  // alternate screen, no cursor
constexpr const char* kClose = "\x1b[?25h\x1b[?1049l";
constexpr const char* kHome = "\x1b[H";
constexpr const char* kRestOfLine = "\x1b[K";
constexpr const char* kRestOfScreen = "\x1b[J";

bool IsLive() {
  const char* const term = std::getenv("TERM");
  return isatty(STDOUT_FILENO) == 1 && term != nullptr && std::string_view(term) != "dumb";
}

// Reads keys without line buffering and echo.
std::optional<termios> TakeKeys() {
  termios before{};
  if (isatty(STDIN_FILENO) == 0 || tcgetattr(STDIN_FILENO, &before) != 0) return std::nullopt;
  termios raw = before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  return before;
}

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
  sheet->Add(Formatted("force  %6.2f N of %.2f N ", sent, limit) + ForceBar(sent, limit, kBar) +
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

struct Terminal::Parts {
  const bool is_live = IsLive();
  const std::optional<termios> before = TakeKeys();
  std::chrono::steady_clock::time_point shown{};
  std::jthread keys;
};

Terminal::Terminal(std::function<void(char)> on_key) : parts_(std::make_unique<Parts>()) {
  if (parts_->is_live) std::fputs(kOpen, stdout);
  if (!parts_->before) return;
  parts_->keys = std::jthread([on_key = std::move(on_key)](const std::stop_token& stop) {
    std::array<char, 64> struck{};
    while (!stop.stop_requested()) {
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (poll(&input, 1, kPatience) <= 0) continue;
      // Of a sequence, such as an arrow key, only the first byte counts. No data: the input is
      // closed.
      if (read(STDIN_FILENO, struck.data(), struck.size()) <= 0) return;
      on_key(struck[0]);
    }
  });
}

Terminal::~Terminal() {
  parts_->keys = {};
  if (parts_->before) tcsetattr(STDIN_FILENO, TCSANOW, &*parts_->before);
  if (!parts_->is_live) return;
  std::fputs(kClose, stdout);
  std::fflush(stdout);
}

Terminal::Size Terminal::size() const {
  winsize size{};
  const bool told = parts_->is_live && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0;
  if (!told || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

bool Terminal::has_colour() const {
  const char* const refused = std::getenv("NO_COLOR");
  return parts_->is_live && (refused == nullptr || *refused == '\0');
}

void Terminal::Show(const std::vector<std::string>& lines) {
  const auto now = std::chrono::steady_clock::now();
  if (!parts_->is_live && now - parts_->shown < kEvery) return;
  parts_->shown = now;
  std::string text = parts_->is_live ? kHome : "";
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const bool ends = !parts_->is_live || i + 1 < lines.size();
    text += lines[i] + (parts_->is_live ? kRestOfLine : "") + (ends ? "\n" : "");
  }
  text += parts_->is_live ? kRestOfScreen : "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
  std::fflush(stdout);
}

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
