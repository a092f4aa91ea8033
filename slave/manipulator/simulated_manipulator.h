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
  // Starts the thread. `on_step` is called from it after every step, first with home. If it takes
  // long (a simulator that waits for a solution), periods are skipped. Throws as TipFollower does.
  SimulatedManipulator(const ManipulatorOptions& options, OnStep on_step);
  ~SimulatedManipulator() override;

  bool Command(const Eigen::Vector3d& p_S_target) noexcept override;
  void Hold() noexcept override;
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override;
  [[nodiscard]] bool at_limit() const noexcept override;
  [[nodiscard]] bool carries_tool() const noexcept override { return on_step_ != nullptr; }

  // Commands that were not finite. Thread-safe.
  [[nodiscard]] std::uint64_t ignored_commands() const noexcept { return ignored_; }
  // Number of skipped periods. Thread-safe.
  [[nodiscard]] std::uint64_t missed_periods() const noexcept { return missed_; }

 private:
  void Run(const std::stop_token& stop);
  Eigen::Vector3d StepBy(double dt) noexcept;
  // False, at once: the tip moves, or has stood for less than a second.
  bool RestUntilSent(const std::stop_token& stop);

  mutable std::mutex mutex_;  // guards follower_; never locked longer than a step
  std::condition_variable_any sent_;
  TipFollower follower_;
  int still_ = 0;  // steps in a row that moved nothing
  OnStep on_step_;
  std::atomic<std::uint64_t> ignored_{0}, missed_{0};
  std::jthread thread_;  // last: it uses everything above
};

}  // namespace palpate
