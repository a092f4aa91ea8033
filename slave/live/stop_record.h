// Reason and time of the emergency stop: reported on request, and saved in a file, so that it
// persists across a restart.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

#include "shared/link/priority_inheritance_mutex.h"

namespace palpate {

class StopRecord {
 public:
  StopRecord() = default;
  virtual ~StopRecord() = default;
  StopRecord(const StopRecord&) = delete;
  StopRecord& operator=(const StopRecord&) = delete;

  // Saves the stop in `folder` from now on. True: a saved stop exists and is active. Throws
  // std::runtime_error: the folder is not writable.
  bool KeepIn(const std::filesystem::path& folder);
  // Thread-safe, as the others. Returns empty, or why it is not saved yet: such a stop is active,
  // and saving is retried every `again` until it succeeds or the stop ends.
  std::string Begin(const std::string& reason) noexcept;
  // Throws std::filesystem::filesystem_error: the file stays, and so does the stop.
  virtual void End();
  void set_again(std::chrono::milliseconds again) noexcept { again_ = again; }
  [[nodiscard]] bool is_active() const;
  // Returns for example `emergency stop for 12 s: by the operator`; empty: no stop.
  [[nodiscard]] std::string Words() const;

 private:
  using Clock = std::chrono::system_clock;  // a stop may be older than the process

  void KeepTrying(const std::stop_token& stop);
  [[nodiscard]] std::string Reason() const;

  std::filesystem::path file_;  // empty: not saved
  std::chrono::milliseconds again_{100};
  std::mutex file_mutex_;  // locked while the file is written or removed; guards the members below
  bool is_kept_ = true;
  std::condition_variable_any changed_;
  mutable PriorityInheritanceMutex mutex_;  // never locked longer; guards the members below
  bool is_active_ = false;
  std::string reason_;
  Clock::time_point since_{};
  std::jthread trying_;  // sleeps until saving has failed
};

}  // namespace palpate
