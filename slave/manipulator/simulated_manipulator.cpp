#include "slave/manipulator/simulated_manipulator.h"

#include <chrono>
#include <utility>

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

using SteadyClock = std::chrono::steady_clock;
constexpr auto kPeriod = std::chrono::milliseconds(1);

}  // namespace

SimulatedManipulator::SimulatedManipulator(const ManipulatorOptions& options, OnStep on_step)
    : follower_(options),
      on_step_(std::move(on_step)),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

SimulatedManipulator::~SimulatedManipulator() = default;

bool SimulatedManipulator::Command(const Eigen::Vector3d& p_S_target) noexcept {
  const std::lock_guard lock(mutex_);
  if (follower_.Aim(p_S_target)) return true;
  ++ignored_;
  return false;
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

Eigen::Vector3d SimulatedManipulator::StepBy(double dt) noexcept {
  const std::lock_guard lock(mutex_);
  follower_.Step(dt);
  return follower_.tip();
}

void SimulatedManipulator::Run(const std::stop_token& stop) {
  MakeThreadRealtime(kLinkPriority);
  auto wake = SteadyClock::now();
  double dt = 0;
  while (!stop.stop_requested()) {
    const Eigen::Vector3d p_S_tip = StepBy(dt);
    if (on_step_) on_step_(p_S_tip);
    const auto lost = (SteadyClock::now() - wake) / kPeriod;
    missed_ += static_cast<std::uint64_t>(lost);
    wake += (lost + 1) * kPeriod;
    dt = std::chrono::duration<double>((lost + 1) * kPeriod).count();
    std::this_thread::sleep_until(wake);
  }
}

}  // namespace palpate
