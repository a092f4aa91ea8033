// Why and since when the tool stands: told to whoever asks, and kept in a file, so that an
// emergency stop outlives the process.
#pragma once

#include <chrono>
#include <filesystem>
#include <mutex>
#include <string>

namespace palpate {

class StopRecord {
 public:
  // Kept in `folder` from now on. True: a stop is kept there already, which goes on. Throws
  // std::runtime_error: nothing can be kept there.
  bool KeepIn(const std::filesystem::path& folder);
  // Thread-safe, as the rest. Empty, or why it will not outlive the process: a stop that cannot be
  // kept still stops.
  std::string Begin(const std::string& reason) noexcept;
  // Throws std::filesystem::filesystem_error: the file stays, and so does the stop.
  void End();
  // `emergency stop for 12 s: by the operator`; empty: none.
  [[nodiscard]] std::string Words() const;

 private:
  using Clock = std::chrono::system_clock;  // a stop may be older than the process

  std::filesystem::path file_;  // empty: it is not kept
  mutable std::mutex mutex_;    // guards what follows
  bool stands_ = false;
  std::string reason_;
  Clock::time_point since_{};
};

}  // namespace palpate
