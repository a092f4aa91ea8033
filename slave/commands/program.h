// Shared parts of the slave's programs: log, stop by signal, exit codes.
#pragma once

#include <atomic>
#include <csignal>
#include <cstddef>
#include <functional>
#include <mutex>
#include <stop_token>
#include <string_view>
#include <thread>

#include <spdlog/sinks/base_sink.h>

namespace palpate {

constexpr int kFailed = 1, kUnusable = 2;

// SIGINT, SIGTERM and SIGHUP request a stop. They are blocked everywhere and taken by one thread,
// so that no other call is ever interrupted. Make one before any thread starts.
class StopOnSignal {
 public:
  StopOnSignal();
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  // A command that is stopped before its result has failed; a service that is stopped has not.
  void ExpectAnswer() { exit_code_ = kFailed; }
  // A stop waits until the recording is complete, which may take longer than other stops. A second
  // signal ends this wait.
  void LetRecordingEnd() { records_ = true; }
  // Action of SIGUSR1, also of one that arrived while there was none; nullptr: none. Called by a
  // thread of this class.
  void OnEmergency(std::function<void()> stop);

 private:
  void Wait(const std::stop_token& end);
  void Emergency();

  std::atomic<int> exit_code_ = 0;
  std::atomic<bool> records_ = false;
  sigset_t signals_{};
  std::stop_source source_;
  std::mutex mutex_;  // guards the members below
  std::function<void()> on_emergency_;
  bool is_emergency_ = false;  // one arrived without an action
  std::jthread waiter_;
};

// Raises the limit of open files to what the system grants. With the usual 1024, a thousand idle
// connections would block all others.
void RaiseDescriptorLimit();

// Writes the log to standard error; standard output is for results.
void LogToStderr();
// Sets up the log of a server, which never waits for a reader of the log: see UnblockedSink.
void LogWithoutWaiting();

// Returns the result of `command`. An exception is printed on standard error: an unusable scene or
// argument gives kUnusable, anything else kFailed. `program`: name in front of the message.
int ExitCode(const std::function<int()>& command, const char* program = "palpate-slave");

// A log that never blocks: a stopped terminal, a hanging supervisor or a full pipe loses lines, but
// does not delay the caller.
//
// Writes all of `text`, or nothing if that would block. At most kMaxUnblocked bytes, which a pipe
// accepts at once.
bool WriteUnblocked(int fd, std::string_view text);
inline constexpr std::size_t kMaxUnblocked = 4096;

// Lost lines are counted, and the next written line reports their number.
class UnblockedSink final : public spdlog::sinks::base_sink<std::mutex> {
 public:
  // Colours levels where `fd` is a terminal.
  explicit UnblockedSink(int fd);

 private:
  void sink_it_(const spdlog::details::log_msg& message) override;
  void flush_() override {}

  int fd_;
  bool colours_;
  std::size_t lost_ = 0;
};

}  // namespace palpate
