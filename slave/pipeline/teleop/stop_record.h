// Why and since when the tool stands: told to whoever asks, and kept in a file, so that an
// emergency stop outlives the process.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <stop_token>
#include <string>
#include <thread>

namespace palpate {

class StopRecord {
 public:
  // Kept in `folder` from now on. True: a stop is kept there already, which goes on. Throws
  // std::runtime_error: nothing can be kept there.
  bool KeepIn(const std::filesystem::path& folder);
  // Thread-safe, as the rest. Empty, or why it does not outlive the process yet: a stop that cannot
  // be kept still stops, and is tried to be kept every `again` until it is or ends.
  std::string Begin(const std::string& reason) noexcept;
  // Throws std::filesystem::filesystem_error: the file stays, and so does the stop.
  void End();
  void set_again(std::chrono::milliseconds again) noexcept { again_ = again; }
  // `emergency stop for 12 s: by the operator`; empty: none.
  [[nodiscard]] std::string Words() const;

 private:
  using Clock = std::chrono::system_clock;  // a stop may be older than the process

  void KeepTrying(const std::stop_token& stop);
  [[nodiscard]] std::string Reason() const;

  std::filesystem::path file_;  // empty: it is not kept
  std::chrono::milliseconds again_{100};
  std::mutex file_mutex_;  // held while the file is written or removed; guards what follows
  bool is_kept_ = true;
  std::condition_variable_any changed_;
  mutable std::mutex mutex_;  // never held for longer; guards what follows
  bool stands_ = false;
  std::string reason_;
  Clock::time_point since_{};
  std::jthread trying_;  // sleeps until one could not be kept
};

}  // namespace palpate
