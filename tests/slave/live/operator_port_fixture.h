// The operator port with an arm that reaches its targets at once.
#pragma once

#include <cstdint>
#include <optional>

#include <gtest/gtest.h>

#include "slave/live/operator_port.h"

namespace palpate {

// A manipulator that reaches its target immediately.
class PerfectManipulator : public Manipulator {
 public:
  bool Command(const Eigen::Vector3d& p_S_target) noexcept override {
    if (moves) tip_ = p_S_target;
    target = p_S_target;
    ++commands_;
    return true;
  }
  void Hold() noexcept override {
    ++holds_;
    stopped = false;
  }
  void Turn(const Eigen::Quaterniond& R_S_target) noexcept override {
    if (rotation) rotation = R_S_target;
    ++turns;
  }
  [[nodiscard]] std::optional<Eigen::Quaterniond> Rotation() const noexcept override {
    return rotation;
  }
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override { return tip_; }
  [[nodiscard]] std::uint32_t frame() const noexcept override { return driver; }
  [[nodiscard]] bool at_limit() const noexcept override { return false; }
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
  void Stop() noexcept override {
    ++holds_;
    stopped = true;
  }
  [[nodiscard]] bool is_faulty() const noexcept override { return faulty; }
  void Place(const Eigen::Vector3d& p_S) { tip_ = p_S; }
  bool faulty = false, stopped = false;
  bool moves = true;
  std::uint32_t driver = 1;
  Eigen::Vector3d target{0, 0, 0};
  std::optional<Eigen::Quaterniond> rotation;
  int turns = 0;
  [[nodiscard]] int commands() const { return commands_; }
  [[nodiscard]] int holds() const { return holds_; }

 private:
  Eigen::Vector3d tip_{0.01, 0.02, 0};
  int commands_ = 0, holds_ = 0;
};

class OperatorPortTest : public ::testing::Test {
 protected:
  OperatorPortTest() { port_.BeginOperating(); }

  OperatorCommand Next(const Eigen::Vector3d& p_M, bool engaged = true, std::uint32_t epoch = 1) {
    OperatorCommand command;
    command.sequence = ++sequence_;
    command.epoch = epoch;
    command.p_M = p_M;
    command.engaged = engaged;
    return command;
  }
  bool Send(const OperatorCommand& command) { return port_.Command(command, now_); }
  void Wait(double seconds, const ContactState& contact = {Eigen::Vector3d::Zero()}) {
    now_ += Seconds(seconds);
    port_.Watch(now_, contact);
  }

  PerfectManipulator arm_;
  TeleopTransform transform_{0.5, 2.0, Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  ManipulatorOptions limits_{.max_speed = 10};
  OperatorPort port_{arm_, transform_, limits_};
  Time now_ = Time{} + Seconds(100);
  std::uint64_t sequence_ = 0;
};

// The arm's speed limit is 20 mm/s. A command may be 0.2 s ahead of the arm, which is 4 mm.
class GuardedPortTest : public OperatorPortTest {
 protected:
  GuardedPortTest() { Use({.max_speed = 0.020}); }
  void Use(const ManipulatorOptions& limits) {
    guarded_.emplace(arm_, TeleopTransform(), limits);
    guarded_->BeginOperating();
    guarded_->Watch(now_, {Eigen::Vector3d::Zero()});
    EXPECT_TRUE(Send(Next({0, 0, 0})));
  }
  bool Send(const OperatorCommand& command) { return guarded_->Command(command, now_); }
  // A contact on top of the object that pushes the tool out with `force` [N], `depth` [m] deep.
  static ContactState Pushing(double force, double depth = 1e-3) {
    return {Eigen::Vector3d(0, force, 0), depth, {0, 1, 0}};
  }
  // At 2 mm/s down for `seconds`, with the force estimated meanwhile.
  void Press(double seconds, const ContactState& contact) {
    for (double t = 0; t < seconds; t += 0.002) {
      now_ += Seconds(0.002);
      y_ -= 4e-6;
      Send(Next({0, y_, 0}, true, epoch_));
      guarded_->Watch(now_, contact);
    }
  }
  Phase phase() const { return guarded_->view().phase; }

  std::optional<OperatorPort> guarded_;
  double y_ = 0;
  std::uint32_t epoch_ = 1;
};

}  // namespace palpate
