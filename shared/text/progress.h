// What long precomputes say of themselves, and how they are told to stop.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string_view>

namespace palpate {

// Expected before the work starts; rough is good enough, a factor of two is not noticed.
struct PrecomputeCost {
  double seconds = 0;
  std::size_t memory_bytes = 0;  // at its peak
};

// Thrown by a precompute that was asked to stop. What it had finished is on disk if the model says
// so.
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
  // `stage`: what is being done, two or three words; `done`: share of it, 0 to 1. Cheap; call it
  // ten times a second or so. False: stop, by throwing Interrupted.
  virtual bool Report(std::string_view /*stage*/, double /*done*/) { return true; }
};

// Reports where there is somebody to listen. Throws Interrupted.
inline void ReportProgress(Progress* progress, std::string_view stage, double done) {
  if (progress != nullptr && !progress->Report(stage, done)) throw Interrupted();
}

}  // namespace palpate
