#include "slave/manipulator/serial_manipulator.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace palpate {
namespace {

constexpr double kLongestStep = 0.2;  // [s]
constexpr double kSmoothing = 0.05;
constexpr auto kRest = std::chrono::milliseconds(5);  // between two round trips

// Asked once more: a line that was just opened may hold half an answer.
Steps Origin(Mp285& drive, const ManipulatorOptions& options) {
  if (!drive.Find() && !drive.Find()) {
    throw std::runtime_error("manipulator.port = " + options.port + ": " + drive.fault());
  }
  return *drive.at();
}

}  // namespace

SerialManipulator::SerialManipulator(const ManipulatorOptions& options, OnStep on_step,
                                     Mp285::Patience patience)
    : options_(options),
      on_step_(std::move(on_step)),
      drive_(options.port, patience),
      origin_(Origin(drive_, options)),
      follower_(options),
      p_S_tip_(options.home),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

Steps SerialManipulator::ToSteps(const Eigen::Vector3d& p_S) const {
  Steps steps = origin_;
  constexpr double kFar = 1e9;  // far beyond the travel, and still a whole number
  for (int i = 0; i < 3; ++i) {
    const double way = (p_S[i] - options_.home[i]) / Mp285::kStep;
    steps[static_cast<std::size_t>(i)] +=
        static_cast<std::int32_t>(std::lround(std::clamp(way, -kFar, kFar)));
  }
  return steps;
}

Eigen::Vector3d SerialManipulator::FromSteps(const Steps& steps) const {
  Eigen::Vector3d p_S = options_.home;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    p_S[i] += Mp285::kStep * (steps[k] - origin_[k]);
  }
  return p_S;
}

bool SerialManipulator::Command(const Eigen::Vector3d& p_S_target) noexcept {
  const std::lock_guard lock(mutex_);
  if (!fault_.empty() || !p_S_target.allFinite()) return false;
  if (!follows_) follower_.Place(p_S_tip_);
  follows_ = true;
  return follower_.Aim(p_S_target);
}

void SerialManipulator::Hold() noexcept {
  const std::lock_guard lock(mutex_);
  follows_ = false;
}

Eigen::Vector3d SerialManipulator::Tip() const noexcept {
  const std::lock_guard lock(mutex_);
  return p_S_tip_;
}

bool SerialManipulator::at_limit() const noexcept {
  const std::lock_guard lock(mutex_);
  return follower_.at_limit();
}

bool SerialManipulator::is_faulty() const noexcept {
  const std::lock_guard lock(mutex_);
  return !fault_.empty();
}

std::optional<ArmHealth> SerialManipulator::health() const {
  const std::lock_guard lock(mutex_);
  return ArmHealth{.driver = "MP-285 on " + options_.port,
                   .fault = fault_,
                   .reports = rounds_,
                   .rate = round_ > 0 ? 1 / round_ : 0};
}

bool SerialManipulator::Round() {
  std::optional<Eigen::Vector3d> target;
  const Time now = Clock::now();
  const double dt = SecondsBetween(std::exchange(stepped_at_, now), now);
  {
    const std::lock_guard lock(mutex_);
    follower_.Step(std::clamp(dt, 0.0, kLongestStep));
    if (follows_) target = follower_.tip();
  }
  if (!target || ToSteps(*target) == *drive_.at()) return drive_.Poll();
  const double way = (*target - FromSteps(*drive_.at())).norm();
  const Mp285::Patience takes(static_cast<int>(2e3 * way / options_.max_speed) + 1);
  return drive_.MoveTo(ToSteps(*target), takes);
}

void SerialManipulator::Run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const Time began = Clock::now();
    const bool is_known = drive_.at() ? Round() : drive_.Find();
    std::optional<Eigen::Vector3d> told;
    {
      const std::lock_guard lock(mutex_);
      fault_ = is_known ? std::string() : drive_.fault();
      if (!is_known) follows_ = false;
      if (is_known) told = p_S_tip_ = FromSteps(*drive_.at());
      ++rounds_;
      const double took = SecondsBetween(began, Clock::now());
      round_ = rounds_ == 1 ? took : round_ + kSmoothing * (took - round_);
    }
    if (told && on_step_) on_step_(*told);
    std::this_thread::sleep_for(kRest);
  }
}

}  // namespace palpate
