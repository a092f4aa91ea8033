#include "master/view/console.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include "master/view/status_line.h"

namespace palpate {
namespace {

constexpr double kSayEvery = 1;  // in a pipe [s]

// A line that wraps cannot be replaced, so it is cut to the terminal's width.
std::string Cut(const std::string& line, std::FILE* out) {
  winsize size{};
  if (ioctl(fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return line;
  return line.substr(0, size.ws_col - 1U);
}

}  // namespace

Console Console::Standard() {
  return {stdout, isatty(STDOUT_FILENO) == 1};
}

void Console::Say(const std::string& line) {
  EndLine();
  std::fprintf(out_, "%s\n", line.c_str());
  std::fflush(out_);
}

void Console::Show(const Status& status) {
  if (live_) {
    std::fprintf(out_, "\r%s\x1b[K", Cut(FormatStatus(status), out_).c_str());
    std::fflush(out_);
    open_ = true;
    return;
  }
  if (state_ == status.tick.state && status.t - said_ < kSayEvery) return;
  state_ = status.tick.state;
  said_ = status.t;
  Say(FormatStatus(status));
}

void Console::EndLine() {
  if (open_) std::fputc('\n', out_);
  open_ = false;
}

}  // namespace palpate
