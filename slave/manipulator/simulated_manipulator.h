// A simulated planar manipulator: a thread steps a TipFollower at 1 kHz and reports the tip. After
// the tip was stationary for a second, the thread sleeps until a new target.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <stop_token>
#include <thread>

#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/tip_follower.h"

namespace palpate {

class SimulatedManipulator : public Manipulator {
 public:
  // Starts the thread. Throws as TipFollower does.
  explicit SimulatedManipulator(const ManipulatorOptions& options);
  ~SimulatedManipulator() override;

  bool Command(const Eigen::Vector3d& p_S_target) noexcept override;
  void Hold() noexcept override;
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override;
  [[nodiscard]] bool at_limit() const noexcept override;
  [[nodiscard]] bool carries_tool() const noexcept override { return false; }

  // Commands that were not finite. Thread-safe.
  [[nodiscard]] std::uint64_t ignored_commands() const noexcept { return ignored_; }
  // Number of skipped periods. Thread-safe.
  [[nodiscard]] std::uint64_t missed_periods() const noexcept { return missed_; }

 private:
  void Run(const std::stop_token& stop);
  void StepBy(double dt) noexcept;
  // False, at once: the tip moves, or has stood for less than a second.
  bool RestUntilSent(const std::stop_token& stop);

  mutable std::mutex mutex_;  // guards follower_; never locked longer than a step
  std::condition_variable_any sent_;
  TipFollower follower_;
  int still_ = 0;  // steps in a row that moved nothing
  std::atomic<std::uint64_t> ignored_{0}, missed_{0};
  std::jthread thread_;  // last: it uses everything above
};

}  // namespace palpate
