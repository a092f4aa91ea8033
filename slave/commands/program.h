// What the slave's programs share: a log beside the answers, an end by signal, exit codes.
#pragma once

#include <atomic>
#include <csignal>
#include <functional>
#include <mutex>
#include <stop_token>
#include <thread>

namespace palpate {

constexpr int kFailed = 1, kUnusable = 2;

// SIGINT, SIGTERM and SIGHUP request a stop. They are blocked everywhere and taken by one thread,
// so that no other call is ever interrupted. Make one before any thread starts.
class StopOnSignal {
 public:
  StopOnSignal();
  [[nodiscard]] std::stop_token token() const { return source_.get_token(); }
  // What is ended before it has answered has failed; a service that is ended has not.
  void ExpectAnswer() { exit_code_ = kFailed; }
  // What was recorded is written to its end, which takes longer than an end may take otherwise; a
  // second signal ends that, too.
  void LetRecordingEnd() { records_ = true; }
  // What SIGUSR1 does, also one that came before; nullptr: nothing. Called by a thread of this.
  void OnEmergency(std::function<void()> stop);

 private:
  void Wait(const std::stop_token& end);
  void Emergency();

  std::atomic<int> exit_code_ = 0;
  std::atomic<bool> records_ = false;
  sigset_t signals_{};
  std::stop_source source_;
  std::mutex mutex_;  // guards what follows
  std::function<void()> on_emergency_;
  bool is_emergency_ = false;
  std::jthread waiter_;
};

// As many files and connections as the system grants: with the usual 1024 a thousand idle strangers
// would close the door for everybody.
void RaiseDescriptorLimit();

// Standard output belongs to the answers; the log goes beside it.
void LogToStderr();
// The same of who serves, and has no time for whoever does not read: see UnblockedSink.
void LogWithoutWaiting();

// What `command` returns. What it throws is said on stderr: an unusable scene or argument is
// kUnusable, anything else kFailed.
int ExitCode(const std::function<int()>& command);

}  // namespace palpate
