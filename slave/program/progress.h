// Progress and interruption of long precomputes.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <stop_token>
#include <string_view>

namespace palpate {

// Expected cost, within a factor of two, before the work starts.
struct PrecomputeCost {
  double seconds = 0;
  std::size_t memory_bytes = 0;  // peak
};

// Thrown by an interrupted precompute. Finished parts are on disk if the model supports it.
class Interrupted : public std::runtime_error {
 public:
  Interrupted() : std::runtime_error("interrupted") {}
};

// Called by the thread that computes. The default does nothing.
class Progress {
 public:
  virtual ~Progress() = default;
  Progress() = default;
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  virtual void Expect(const PrecomputeCost& /*cost*/) {}
  // `stage`: two or three words; `done`: completed fraction, 0 to 1. Call it about ten times per
  // second. If it returns false, stop by throwing Interrupted.
  virtual bool Report(std::string_view /*stage*/, double /*done*/) { return true; }
  // For work that has no stages: requested when Report would return false.
  [[nodiscard]] virtual std::stop_token stop() const { return {}; }
};

// The token of `progress`; of null: one that is never requested.
inline std::stop_token StopOf(const Progress* progress) {
  return progress != nullptr ? progress->stop() : std::stop_token();
}

// Reports to `progress`, unless it is null. Throws Interrupted.
inline void ReportProgress(Progress* progress, std::string_view stage, double done) {
  if (progress != nullptr && !progress->Report(stage, done)) throw Interrupted();
}

}  // namespace palpate
