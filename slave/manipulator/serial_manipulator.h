// A micromanipulator on a serial port as Manipulator: small moves at the rate of the port, each
// followed by a position query.
#pragma once

#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/mp285.h"
#include "slave/manipulator/tip_follower.h"

namespace palpate {

// Its axes are parallel to those of S; its position at the start is manipulator.home. While the
// position is unknown, it has a fault, nothing moves, and it keeps querying.
class SerialManipulator final : public Manipulator {
 public:
  // Opens the port and reads the position. Throws std::runtime_error naming manipulator.port
  // without an answer, and as TipFollower does.
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
  // One round trip over the port; false: fault.
  bool Round();
  [[nodiscard]] Steps ToSteps(const Eigen::Vector3d& p_S) const;
  [[nodiscard]] Eigen::Vector3d FromSteps(const Steps& steps) const;

  const ManipulatorOptions options_;
  const OnStep on_step_;
  Mp285 drive_;  // the thread's, once it runs
  const Steps origin_;
  Time stepped_at_ = Clock::now();  // the thread's

  mutable std::mutex mutex_;  // guards the members below; never locked during a round trip
  TipFollower follower_;
  Eigen::Vector3d p_S_tip_;
  bool follows_ = false;
  std::string fault_;
  std::uint64_t rounds_ = 0;
  double round_ = 0;     // smoothed [s]
  std::jthread thread_;  // last
};

}  // namespace palpate
