#include "master/view/console.h"

#include <utility>

#include <sys/ioctl.h>
#include <unistd.h>

#include "master/view/finger_table.h"
#include "master/view/status_line.h"

namespace palpate {
namespace {

constexpr double kSayEvery = 1;  // in a pipe [s]

// A line that wraps cannot be replaced, so lines are cut to the terminal's width; nor can those
// that have scrolled away, so their number is cut to its height.
std::vector<std::string> Cut(std::vector<std::string> lines, std::FILE* out) {
  winsize size{};
  if (ioctl(fileno(out), TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return lines;
  for (std::string& line : lines) line = line.substr(0, size.ws_col - 1U);
  if (size.ws_row > 1 && lines.size() >= size.ws_row) lines.resize(size.ws_row - 1U);
  return lines;
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

void Console::Show(const Status& status, const RemoteMesh* mesh) {
  if (live_) {
    std::vector<std::string> lines{FormatStatus(status)};
    const auto table = FingerTable(status.fingers, mesh);
    lines.insert(lines.end(), table.begin(), table.end());
    return ShowLive(Cut(std::move(lines), out_));
  }
  if (state_ == status.tick.state && status.t - said_ < kSayEvery) return;
  state_ = status.tick.state;
  said_ = status.t;
  Say(FormatStatus(status) + FingerBrief(status.fingers, mesh));
}

// Back to the first of the lines that stand there, over them, and away with what is left below.
void Console::ShowLive(const std::vector<std::string>& lines) {
  if (open_ > 1) std::fprintf(out_, "\x1b[%zuA", open_ - 1);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::fprintf(out_, "%s\r%s\x1b[K", i > 0 ? "\n" : "", lines[i].c_str());
  }
  if (open_ > lines.size()) std::fputs("\x1b[J", out_);
  std::fflush(out_);
  open_ = lines.size();
}

void Console::EndLine() {
  if (open_ > 0) std::fputc('\n', out_);
  open_ = 0;
}

}  // namespace palpate
