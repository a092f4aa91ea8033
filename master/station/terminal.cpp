#include "master/station/terminal.h"

#include <array>
#include <chrono>
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

}  // namespace palpate
