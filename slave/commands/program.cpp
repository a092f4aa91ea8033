#include "slave/commands/program.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/resource.h>
#include <unistd.h>

#include "slave/commands/unblocked_log.h"
#include "slave/scene/scene_loader.h"

namespace palpate {
namespace {

// For a command to end by itself after a signal; what computes for longer, a large model say, hears
// nothing, moves nothing and has every row it wrote flushed.
constexpr std::chrono::seconds kPatience(2);
// For pictures that wait to be packed: 256 MB of them, where processors are busy.
constexpr std::chrono::seconds kRecordingPatience(30);

constexpr const char* kPattern = "%^%l%$ %v";

}  // namespace

StopOnSignal::StopOnSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  sigaddset(&signals_, SIGUSR1);
  struct sigaction hang_up {};  // nohup: the terminal may go
  if (sigaction(SIGHUP, nullptr, &hang_up) == 0 && hang_up.sa_handler != SIG_IGN) {
    sigaddset(&signals_, SIGHUP);
  }
  pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  waiter_ = std::jthread([this](const std::stop_token& end) { Wait(end); });
}

void StopOnSignal::Wait(const std::stop_token& end) {
  const timespec pause{0, 50'000'000};
  std::optional<std::chrono::steady_clock::time_point> last_call;
  while (!end.stop_requested()) {
    const auto now = std::chrono::steady_clock::now();
    const int came = sigtimedwait(&signals_, nullptr, &pause);
    if (came == SIGUSR1) Emergency();
    if (came > 0 && came != SIGUSR1) {
      const bool is_first = !last_call;
      source_.request_stop();
      last_call = std::min(last_call.value_or(now + kRecordingPatience),
                           now + (is_first && records_ ? kRecordingPatience : kPatience));
    }
    if (last_call && now > *last_call) {
      if (records_) WriteUnblocked(STDERR_FILENO, "stopped before the recording was closed\n");
      if (exit_code_ != 0) WriteUnblocked(STDERR_FILENO, "stopped before completion\n");
      std::_Exit(records_ ? kFailed : exit_code_.load());
    }
  }
}

void StopOnSignal::Emergency() {
  const std::scoped_lock lock(mutex_);
  is_emergency_ = true;
  if (on_emergency_) on_emergency_();
}

void StopOnSignal::OnEmergency(std::function<void()> stop) {
  const std::scoped_lock lock(mutex_);
  on_emergency_ = std::move(stop);
  if (on_emergency_ && is_emergency_) on_emergency_();
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

int ExitCode(const std::function<int()>& command) {
  try {
    return command();
  } catch (const SceneError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    return kUnusable;
  } catch (const std::invalid_argument& e) {
    std::fprintf(stderr, "palpate-slave: %s\n", e.what());
    return kUnusable;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "palpate-slave: %s\n", e.what());
    return kFailed;
  }
}

}  // namespace palpate
