#include "slave/commands/program.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>

#include <poll.h>
#include <spdlog/fmt/fmt.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include "shared/program/program.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

// Time for a command to end by itself after a signal. Longer computations, for example of a large
// model, do not poll for signals; they move nothing, and all written rows are flushed.
constexpr std::chrono::seconds kTimeout(2);
// Time to compress the waiting images of a recording: up to 256 MB on busy processors.
constexpr std::chrono::seconds kRecordingTimeout(30);

constexpr const char* kPattern = "%^%l%$ %v";

constexpr std::string_view kPlain = "\033[m", kShortened = "...\n";

std::string_view ColourOf(spdlog::level::level_enum level) {
  constexpr std::string_view kGreen = "\033[32m", kYellow = "\033[33m\033[1m",
                             kRed = "\033[31m\033[1m";
  if (level >= spdlog::level::err) return kRed;
  return level == spdlog::level::warn ? kYellow : kGreen;
}

// Returns the signal that arrives before `end`, else a negative number.
int WaitUntil(std::chrono::steady_clock::time_point end, const sigset_t& signals) {
  using std::chrono::nanoseconds;
  constexpr std::int64_t kNanosPerSecond = 1'000'000'000;
  const nanoseconds left = std::max<nanoseconds>(end - std::chrono::steady_clock::now(), {});
  const timespec pause{left.count() / kNanosPerSecond, left.count() % kNanosPerSecond};
  return sigtimedwait(&signals, nullptr, &pause);
}

}  // namespace

StopOnSignal::StopOnSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  sigaddset(&signals_, SIGUSR1);
  struct sigaction hang_up {};  // nohup: the terminal may be closed
  if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) {
    sigaddset(&signals_, SIGHUP);
  }
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  waiter_ = std::jthread([this](const std::stop_token& end) { Wait(end); });
}

void StopOnSignal::Wait(const std::stop_token& end) {
  // Ends the wait by a signal to this thread only.
  const std::stop_callback wake(end, [waiter = pthread_self()] { pthread_kill(waiter, SIGUSR1); });
  std::optional<std::chrono::steady_clock::time_point> last_call;
  while (true) {
    const int came = last_call ? WaitUntil(*last_call, signals_) : sigwaitinfo(&signals_, nullptr);
    if (end.stop_requested()) return;
    if (came == SIGUSR1) Emergency();
    const auto now = std::chrono::steady_clock::now();
    if (came > 0 && came != SIGUSR1) {
      const bool is_first = !last_call;
      source_.request_stop();
      last_call = std::min(last_call.value_or(now + kRecordingTimeout),
                           now + (is_first && records_ ? kRecordingTimeout : kTimeout));
    }
    if (last_call && now >= *last_call) {
      if (records_) WriteUnblocked(STDERR_FILENO, "stopped before the recording was closed\n");
      if (exit_code_ != 0) WriteUnblocked(STDERR_FILENO, "stopped before completion\n");
      std::_Exit(records_ ? kFailed : exit_code_.load());
    }
  }
}

void StopOnSignal::Emergency() {
  const std::scoped_lock lock(mutex_);
  is_emergency_ = on_emergency_ == nullptr;
  if (on_emergency_) on_emergency_();
}

void StopOnSignal::OnEmergency(std::function<void()> stop) {
  const std::scoped_lock lock(mutex_);
  on_emergency_ = std::move(stop);
  if (on_emergency_ && std::exchange(is_emergency_, false)) on_emergency_();
}

void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  if (setrlimit(RLIMIT_NOFILE, &limit) != 0)
    spdlog::warn("the limit of open files could not be raised");
}

void LogToStderr() {
  spdlog::set_default_logger(spdlog::stderr_color_mt("palpate"));
  spdlog::set_pattern(kPattern);
}

void LogWithoutWaiting() {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("palpate", std::make_shared<UnblockedSink>(STDERR_FILENO)));
  spdlog::set_pattern(kPattern);
}

int ExitCode(const std::function<int()>& command, const char* program) {
  try {
    const int code = command();
    if (code != 0 || !OutputIsOnFullDisk()) return code;
    std::fprintf(stderr, "%s: standard output cannot be written\n", program);
    return kFailed;
  } catch (const SceneError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return kUnusable;
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "%s: %s\n", program, e.what());
    return kUnusable;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "%s: %s\n", program, e.what());
    return kFailed;
  }
}

bool WriteUnblocked(int fd, std::string_view text) {
  text = text.substr(0, kMaxUnblocked);
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
    const auto warning =
        fmt::format("warning {} lines of this log are lost: the reader did not keep up\n", lost_);
    if (WriteUnblocked(fd_, warning)) lost_ = 0;
  }
  spdlog::memory_buf_t line;
  formatter_->format(message, line);
  std::string text(line.data(), line.size());
  if (colours_ && message.color_range_start < message.color_range_end) {
    text.insert(message.color_range_end, kPlain);
    text.insert(message.color_range_start, ColourOf(message.level));
  }
  if (text.size() > kMaxUnblocked) {
    text.replace(kMaxUnblocked - kShortened.size(), std::string::npos, kShortened);
  }
  if (lost_ > 0 || !WriteUnblocked(fd_, text)) ++lost_;
}

}  // namespace palpate
