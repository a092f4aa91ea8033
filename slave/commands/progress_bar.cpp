#include "slave/commands/progress_bar.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kWorthSaying = 0.5;   // [s]
constexpr double kBetweenDraws = 0.1;  // [s]
constexpr int kWidestBar = 40, kNarrowestBar = 8;
constexpr std::string_view kEraseLine = "\r\x1b[K";

std::string Number(double value, const char* unit) {
  return Formatted(value < 9.95 ? "%.1f %s" : "%.0f %s", value, unit);
}

std::string Duration(double seconds) {
  if (seconds < 1) return "less than a second";
  if (seconds < 120) return Number(seconds, "s");
  if (seconds < 7200) return Number(seconds / 60, "min");
  return Number(seconds / 3600, "h");
}

std::string Memory(std::size_t bytes) {
  const double mega = static_cast<double>(bytes) * 1e-6;
  return mega < 1000 ? Number(mega, "MB") : Number(mega * 1e-3, "GB");
}

std::string Percent(double done) {
  return Formatted(" %3d %%", static_cast<int>(100 * done));
}

// Returns the remaining time from the progress of this stage; unknown while too little is done.
std::string TimeLeft(double spent, double done) {
  if (done >= 1 || done < 0.01 || spent <= 0) return "";
  return ", " + Duration(spent * (1 - done) / done) + " left";
}

int ColumnsOf(int descriptor) {
  winsize size{};
  const bool known = ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

ProgressBar::Output StandardError() {
  const bool is_terminal = isatty(STDERR_FILENO) != 0;
  return {is_terminal, is_terminal ? ColumnsOf(STDERR_FILENO) : 80,
          [](std::string_view text) {
            std::fwrite(text.data(), 1, text.size(), stderr);
            std::fflush(stderr);
          },
          [] {
            const auto now = std::chrono::steady_clock::now().time_since_epoch();
            return std::chrono::duration<double>(now).count();
          }};
}

}  // namespace

ProgressBar::ProgressBar(std::string name, std::stop_token stop)
    : ProgressBar(std::move(name), std::move(stop), StandardError()) {}

ProgressBar::ProgressBar(std::string name, std::stop_token stop, Output output)
    : name_(std::move(name)),
      stop_(std::move(stop)),
      output_(std::move(output)),
      started_(output_.now()) {}

ProgressBar::~ProgressBar() {
  Clear();
}

void ProgressBar::Clear() {
  if (on_screen_) output_.write(kEraseLine);
  on_screen_ = false;
}

void ProgressBar::Expect(const PrecomputeCost& cost) {
  if (!(cost.seconds >= kWorthSaying)) return;
  long_ = true;
  Clear();
  output_.write(name_ + ": expected " + Duration(cost.seconds) + " and " +
                Memory(cost.memory_bytes) + " of memory\n");
}

bool ProgressBar::Report(std::string_view stage, double done) {
  const double now = output_.now();
  done = done > 0 ? std::min(done, 1.0) : 0;  // this form maps NaN to 0
  if (stage != stage_) {
    stage_ = stage;
    stage_started_ = now;
    tenths_printed_ = -1;
    drawn_at_ = -std::numeric_limits<double>::infinity();
  }
  long_ = long_ || now - started_ >= kWorthSaying;
  if (long_) output_.is_terminal ? Draw(now, done) : WriteLine(now, done);
  return !stop_.stop_requested();
}

void ProgressBar::Draw(double now, double done) {
  if (now - drawn_at_ < kBetweenDraws) return;
  drawn_at_ = now;
  const std::string head = name_ + ": " + stage_;
  const std::string tail = Percent(done) + TimeLeft(now - stage_started_, done);
  const int room = output_.columns - 1 - static_cast<int>(head.size() + tail.size()) - 3;
  std::string line = head;
  if (room >= kNarrowestBar) {
    const auto width = static_cast<std::size_t>(std::min(room, kWidestBar));
    const auto full = static_cast<std::size_t>(std::lround(done * static_cast<double>(width)));
    line += " [";
    line.append(full, '#').append(width - full, '.') += "]";
  }
  line += tail;
  // A line that wraps could not be overwritten.
  line.resize(std::min(line.size(), static_cast<std::size_t>(std::max(output_.columns - 1, 1))));
  output_.write(std::string(kEraseLine) + line);
  on_screen_ = true;
}

void ProgressBar::WriteLine(double now, double done) {
  const int tenths = static_cast<int>(10 * done);
  if (tenths <= tenths_printed_) return;
  tenths_printed_ = tenths;
  output_.write(name_ + ": " + stage_ + Percent(done) + TimeLeft(now - stage_started_, done) +
                "\n");
}

}  // namespace palpate
