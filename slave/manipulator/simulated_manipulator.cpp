#include "slave/manipulator/simulated_manipulator.h"

#include <chrono>
#include <utility>

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr auto kPeriod = std::chrono::milliseconds(1);
constexpr int kRestAfter = 1000;  // steps: what the site solves for a still tool is solved by then

}  // namespace

SimulatedManipulator::SimulatedManipulator(const ManipulatorOptions& options)
    : follower_(options), thread_([this](const std::stop_token& stop) { Run(stop); }) {}

SimulatedManipulator::~SimulatedManipulator() = default;

bool SimulatedManipulator::Command(const Eigen::Vector3d& p_S_target) noexcept {
  const std::lock_guard lock(mutex_);
  if (!follower_.Aim(p_S_target)) {
    ++ignored_;
    return false;
  }
  if (std::exchange(still_, 0) >= kRestAfter) sent_.notify_all();
  return true;
}

void SimulatedManipulator::Hold() noexcept {
  const std::lock_guard lock(mutex_);
  follower_.Hold();
}

Eigen::Vector3d SimulatedManipulator::Tip() const noexcept {
  const std::lock_guard lock(mutex_);
  return follower_.tip();
}

bool SimulatedManipulator::at_limit() const noexcept {
  const std::lock_guard lock(mutex_);
  return follower_.at_limit();
}

void SimulatedManipulator::StepBy(double dt) noexcept {
  const std::lock_guard lock(mutex_);
  const Eigen::Vector3d before = follower_.tip();
  follower_.Step(dt);
  still_ = follower_.tip() == before ? still_ + 1 : 0;
}

bool SimulatedManipulator::RestUntilSent(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  if (still_ < kRestAfter) return false;
  sent_.wait(lock, stop, [this] { return still_ < kRestAfter; });
  return true;
}

void SimulatedManipulator::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kLinkPriority);
  auto wake = SteadyClock::now();
  double dt = 0;
  while (!stop.stop_requested()) {
    StepBy(dt);
    if (RestUntilSent(stop)) {  // no periods were missed, and nothing moved
      wake = SteadyClock::now();
      dt = 0;
      continue;
    }
    const auto lost = (SteadyClock::now() - wake) / kPeriod;
    missed_ += static_cast<std::uint64_t>(lost);
    wake += (lost + 1) * kPeriod;
    dt = std::chrono::duration<double>((lost + 1) * kPeriod).count();
    std::this_thread::sleep_until(wake);
  }
}

}  // namespace palpate
