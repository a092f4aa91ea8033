#include "slave/commands/unblocked_log.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <string>

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>

namespace palpate {
namespace {

constexpr std::string_view kPlain = "\033[m", kShortened = "...\n";

std::string_view ColourOf(spdlog::level::level_enum level) {
  constexpr std::string_view kGreen = "\033[32m", kYellow = "\033[33m\033[1m",
                             kRed = "\033[31m\033[1m";
  if (level >= spdlog::level::err) return kRed;
  return level == spdlog::level::warn ? kYellow : kGreen;
}

}  // namespace

bool WriteUnblocked(int fd, std::string_view text) {
  text = text.substr(0, kMostUnblocked);
  while (!text.empty()) {
    pollfd ready{fd, POLLOUT, 0};
    if (poll(&ready, 1, 0) != 1 || ready.revents != POLLOUT) return false;
    const ssize_t written = write(fd, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

UnblockedSink::UnblockedSink(int fd) : fd_(fd), colours_(isatty(fd) == 1) {}

void UnblockedSink::sink_it_(const spdlog::details::log_msg& message) {
  if (lost_ > 0) {
    const auto said =
        fmt::format("warning {} lines of this log are lost: the reader did not keep up\n", lost_);
    if (WriteUnblocked(fd_, said)) lost_ = 0;
  }
  spdlog::memory_buf_t line;
  formatter_->format(message, line);
  std::string said(line.data(), line.size());
  if (colours_ && message.color_range_start < message.color_range_end) {
    said.insert(message.color_range_end, kPlain);
    said.insert(message.color_range_start, ColourOf(message.level));
  }
  if (said.size() > kMostUnblocked) {
    said.replace(kMostUnblocked - kShortened.size(), std::string::npos, kShortened);
  }
  if (lost_ > 0 || !WriteUnblocked(fd_, said)) ++lost_;
}

}  // namespace palpate
