#include "master/watch/watch.h"

#include <chrono>
#include <cstdio>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <sys/ioctl.h>
#include <unistd.h>

#include "master/watch/fleet.h"
#include "shared/nats/nats_connection.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kShowEvery = 1;  // [s]
constexpr auto kPoll = std::chrono::milliseconds(50);
constexpr std::size_t kNewsShown = 5;
constexpr const char* kOpen = "\x1b[?1049h\x1b[?25l";  // alternate screen, no cursor
constexpr const char* kClose = "\x1b[?25h\x1b[?1049l";
constexpr const char* kHome = "\x1b[H";
constexpr const char* kRestOfLine = "\x1b[K\r\n";
constexpr const char* kRestOfScreen = "\x1b[J";

// Passes messages about the connection from the library's threads to the output thread.
class NewsBox {
 public:
  void Put(const std::string& text) {
    const std::scoped_lock lock(mutex_);
    if (news_.size() < kNewsShown) news_.push_back(text);
  }
  std::vector<std::string> Take() {
    const std::scoped_lock lock(mutex_);
    return std::exchange(news_, {});
  }

 private:
  std::mutex mutex_;  // guards the next member
  std::vector<std::string> news_;
};

// Writes tables and messages about the connection.
class Output {
 public:
  explicit Output(bool json) : json_(json), live_(!json && isatty(STDOUT_FILENO) == 1) {
    if (live_) std::fputs(kOpen, stdout);
  }
  ~Output() {
    if (live_) std::fputs(kClose, stdout);
    std::fflush(stdout);
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  void Tell(const std::string& news) {
    if (!live_) std::fprintf(stderr, "palpate-master: %s\n", news.c_str());
    news_.push_back(news);
    if (news_.size() > kNewsShown) news_.pop_front();
  }
  // Returns false if the output was closed.
  bool Show(const std::vector<SlaveLine>& lines) {
    if (live_) {
      ShowLive(FleetTable(lines));
    } else if (json_) {
      for (const SlaveLine& line : lines) std::puts(FleetJson(line).c_str());
    } else {
      for (const std::string& line : FleetTable(lines)) std::puts(line.c_str());
    }
    return std::fflush(stdout) == 0;
  }

 private:
  // Lines that wrap or scroll could not be replaced: they are cut.
  void ShowLive(std::vector<std::string> lines) const {
    winsize size{};
    const bool is_known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    const std::size_t columns = is_known ? size.ws_col : 80, rows = is_known ? size.ws_row : 24;
    const std::size_t room = rows > news_.size() + 2 ? rows - news_.size() - 1 : 1;
    if (lines.size() > room) {
      lines.resize(room - 1);
      lines.push_back("... more slaves: enlarge the window, or use --json");
    }
    lines.insert(lines.end(), news_.begin(), news_.end());
    std::fputs(kHome, stdout);
    for (const std::string& line : lines) {
      std::fputs(Presentable(line, columns - 1).c_str(), stdout);
      std::fputs(kRestOfLine, stdout);
    }
    std::fputs(kRestOfScreen, stdout);
  }

  const bool json_, live_;
  std::deque<std::string> news_;
};

}  // namespace

int RunWatch(const WatchOptions& options, const std::function<bool()>& stopped) {
  // Pause after which the server may have disconnected this program [s].
  constexpr double kPaused = 1;
  const NatsServer server = ParseNatsServer(options.url, options.insecure, options.tls);
  Fleet fleet;
  NewsBox box;
  Output output(options.json);
  NatsConnection connection(server, options.name, [&](const auto& news) { box.Put(news); });
  connection.ReportSlowClients();
  for (const char* kind : {"palpate.*.state", "palpate.*.status"}) {
    connection.Subscribe(kind, [&](std::string_view subject, std::string_view bytes) {
      fleet.Take(subject, bytes, Clock::now());
    });
  }
  const Time begun = Clock::now();
  Time shown = begun;
  bool was_connected = false, is_over = false;
  while (!is_over && !stopped()) {
    const Time before = Clock::now();
    std::this_thread::sleep_for(kPoll);
    const Time now = Clock::now();
    const double pause = SecondsBetween(before, now);
    if (pause > kPaused) {
      output.Tell(
          Formatted("this program stood still for %.1f s and read nothing: the NATS server "
                    "cuts off those who do not read",
                    pause));
    }
    for (const std::string& news : box.Take()) output.Tell(news);
    was_connected = connection.Connected() || was_connected;
    is_over = options.duration > 0 && SecondsBetween(begun, now) >= options.duration;
    if (!is_over && SecondsBetween(shown, now) < kShowEvery) continue;
    shown = now;
    if (!output.Show(fleet.Lines(now))) break;
  }
  return was_connected ? 0 : 1;
}

}  // namespace palpate
