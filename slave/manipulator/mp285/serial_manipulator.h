// A micromanipulator on a serial line as an arm of ours: small moves at the pace of the line, after
// each of which it says where it is.
#pragma once

#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/mp285/mp285.h"
#include "slave/manipulator/tip_follower.h"

namespace palpate {

// Its axes lie along those of S; where it stands at the start is manipulator.home. While its place
// is not known it has a fault, nothing moves, and it is looked for.
class SerialManipulator final : public Manipulator {
 public:
  // Opens the line and asks where it is. Throws std::runtime_error naming manipulator.port where
  // nothing answers, and as TipFollower does.
  SerialManipulator(const ManipulatorOptions& options, OnStep on_step,
                    Mp285::Patience patience = Mp285::Patience(250));

  bool Command(const Eigen::Vector3d& p_S_target) noexcept override;
  void Hold() noexcept override;
  void Stop() noexcept override { Hold(); }
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override;
  [[nodiscard]] bool at_limit() const noexcept override;
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
  [[nodiscard]] bool is_faulty() const noexcept override;
  [[nodiscard]] std::optional<ArmHealth> health() const override;

 private:
  void Run(const std::stop_token& stop);
  // One round trip over the line; false: fault.
  bool Round();
  [[nodiscard]] Steps ToSteps(const Eigen::Vector3d& p_S) const;
  [[nodiscard]] Eigen::Vector3d FromSteps(const Steps& steps) const;

  const ManipulatorOptions options_;
  const OnStep on_step_;
  Mp285 drive_;  // the thread's, once it runs
  const Steps origin_;
  Time stepped_at_ = Clock::now();  // the thread's

  mutable std::mutex mutex_;  // guards what follows; never held over a round trip
  TipFollower follower_;
  Eigen::Vector3d p_S_tip_;
  bool follows_ = false;
  std::string fault_;
  std::uint64_t rounds_ = 0;
  double round_ = 0;     // smoothed [s]
  std::jthread thread_;  // last
};

}  // namespace palpate
