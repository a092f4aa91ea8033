#include "slave/pipeline/teleop/command_watchdog.h"

#include <chrono>
#include <optional>
#include <stdexcept>
#include <utility>

#include <spdlog/fmt/fmt.h>

#include "shared/link/thread_priority.h"

namespace palpate {
namespace {

constexpr auto kWatchPeriod = std::chrono::milliseconds(2);
constexpr double kMaxForceLimit = 100;     // [N]
constexpr double kMaxYoungModulus = 1e13;  // [Pa]

void Check(const char* name, std::optional<double> value, double high) {
  if (!value || (*value > 0 && *value <= high)) return;
  throw std::invalid_argument(
      fmt::format("{} = {:g}: accepted is 0 < {} <= {:g}", name, *value, name, high));
}

}  // namespace

CommandWatchdog::CommandWatchdog(OperatorPort& port, std::function<Eigen::Vector3d()> force)
    : thread_([&port, force = std::move(force)](const std::stop_token& stop) {
        MakeThreadRealtime(kLinkPriority);
        while (!stop.stop_requested()) {
          port.Watch(Clock::now(), force());
          std::this_thread::sleep_for(kWatchPeriod);
        }
      }) {}

void RefuseWhileFollowing(const OperatorPort& port) {
  if (port.view().phase == Phase::kFollowing) {
    throw std::logic_error("the model changes only while nobody follows: open the clutch first");
  }
}

void CheckRanges(const ParameterChange& change) {
  Check("position_scale", change.position_scale, kMaxPositionScale);
  Check("force_scale", change.force_scale, kMaxForceScale);
  Check("force_limit", change.force_limit, kMaxForceLimit);
  Check("young_modulus", change.young_modulus, kMaxYoungModulus);
}

}  // namespace palpate
