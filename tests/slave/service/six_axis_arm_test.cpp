// Tests the whole slave over gRPC with a six-axis arm (DriveTool) and an operator (Operate).
//
// The arm is difficult to control: its wrist moves in steps of its resolution, lags, has a dead
// time and a speed limit; its encoders are noisy and report a quaternion or its negative at random.
// It interpolates linearly to the target quaternion, so a target with the wrong sign would make it
// rotate the long way.
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>

#include "palpate/v1/teleoperation.grpc.pb.h"

#include "shared/state/clock.h"
#include "shared/wire/fields.h"
#include "slave/live/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "slave/service/server.h"
#include "tests/support/dice.h"
#include "tests/support/eventually.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kResolution = 4e-3;    // of each component of a rotation vector [rad]
constexpr double kNoise = 1e-4;         // of the encoders, one sigma about each axis [rad]
constexpr double kServo = 0.02;         // time constant of the wrist [s]
constexpr double kWristSpeed = 1.2;     // [rad/s]
constexpr std::size_t kDeadTime = 5;    // targets
constexpr double kMaxAngularSpeed = 2;  // of the scene [rad/s]
constexpr auto kPeriod = std::chrono::milliseconds(4);
// Allowed deviation of a held arm: half a step about each axis, and five sigma of the two readings
// at the start of an engagement.
const double kWithin = std::sqrt(3.0) * kResolution / 2 + 10 * std::sqrt(3.0) * kNoise;

Quaterniond ToRotation(const google::protobuf::RepeatedField<double>& numbers) {
  return {numbers[0], numbers[1], numbers[2], numbers[3]};
}

class Arm {
 public:
  Arm(std::unique_ptr<v1::Teleoperation::Stub> stub, const Vector3d& home,
      const Quaterniond& rotation)
      : stub_(std::move(stub)), tip_(home), rotation_(rotation) {
    context_.set_deadline(std::chrono::system_clock::now() + 3 * kLiveness);
    stream_ = stub_->DriveTool(&context_);
    reading_ = std::jthread([this] { Read(); });
    reporting_ = std::jthread([this](const std::stop_token& stop) { Run(stop); });
  }
  ~Arm() {
    reporting_.request_stop();
    reporting_.join();
    context_.TryCancel();
  }

  // Returns the true orientation of the wrist.
  [[nodiscard]] Quaterniond rotation() const {
    const std::scoped_lock lock(mutex_);
    return rotation_;
  }
  // The largest angular speed from target to target [rad/s], and whether one changed sign.
  [[nodiscard]] double fastest() const { return fastest_; }
  [[nodiscard]] bool flipped() const { return flipped_; }

 private:
  void Read() {
    v1::ArmTarget target;
    while (stream_->Read(&target)) {
      const std::scoped_lock lock(mutex_);
      Judge(target);
      newest_ = target;
      queue_.push_back(target);
    }
  }
  void Judge(const v1::ArmTarget& target) {
    if (target.orientation_size() != 4 || newest_.orientation_size() != 4) return;
    const Quaterniond now = ToRotation(target.orientation()),
                      last = ToRotation(newest_.orientation());
    if (now.dot(last) < 0) flipped_ = true;
    if (target.motion() != v1::ArmTarget::MOTION_FOLLOW ||
        newest_.motion() != v1::ArmTarget::MOTION_FOLLOW) {
      return;
    }
    std::string reason;
    FieldReader reader(&reason);
    const double dt =
        SecondsBetween(reader.Stamp("", newest_.sent_at()), reader.Stamp("", target.sent_at()));
    fastest_ = std::max<double>(fastest_, now.angularDistance(last) / std::max(dt, 1e-4));
  }
  void Run(const std::stop_token& stop) {
    Dice dice(5);
    for (std::uint64_t i = 1; !stop.stop_requested(); ++i) {
      Step(std::chrono::duration<double>(kPeriod).count());
      if (!stream_->Write(Report(i, &dice))) return;
      std::this_thread::sleep_for(kPeriod);
    }
  }
  void Step(double dt) {
    const std::scoped_lock lock(mutex_);
    while (queue_.size() > kDeadTime) {
      obeyed_ = queue_.front();
      queue_.pop_front();
    }
    if (obeyed_.motion() != v1::ArmTarget::MOTION_FOLLOW) return;
    tip_ = {obeyed_.p_s_tip().x(), obeyed_.p_s_tip().y(), obeyed_.p_s_tip().z()};
    if (obeyed_.orientation_size() != 4) return;
    // Interpolates the four numbers linearly, in whole steps, until less than half a step is
    // missing about each axis.
    const Quaterniond way = ToRotation(obeyed_.orientation()) * rotation_.conjugate();
    const double angle = 2 * std::atan2(way.vec().norm(), way.w());
    const double length = std::min((1 - std::exp(-dt / kServo)) * angle, kWristSpeed * dt);
    residue_ += length * way.vec().stableNormalized();
    Vector3d steps = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      const double missing = angle * way.vec().stableNormalized()[c];
      if (std::abs(missing) <= kResolution / 2) residue_[c] = 0;
      steps[c] = kResolution * std::trunc(residue_[c] / kResolution);
    }
    residue_ -= steps;
    if (steps.isZero()) return;
    rotation_ = AngleAxisd(steps.norm(), steps.normalized()) * rotation_;
    rotation_.normalize();
  }
  v1::ArmReport Report(std::uint64_t sequence, Dice* dice) {
    const std::scoped_lock lock(mutex_);
    v1::ArmReport report;
    report.set_sequence(sequence);
    report.set_driver_name("fake six-axis arm");
    report.set_rate(250);
    ToProto(Clock::now(), report.mutable_measured_at());
    ToProto(tip_, report.mutable_p_s_tip());
    const Vector3d noise = kNoise * Vector3d(dice->Normal(), dice->Normal(), dice->Normal());
    Quaterniond measured(AngleAxisd(noise.norm(), noise.stableNormalized()) * rotation_);
    if (dice->Chance(0.5)) measured.coeffs() *= -1;
    ToProto(std::optional(measured), report.mutable_orientation());
    return report;
  }

  std::unique_ptr<v1::Teleoperation::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::ArmReport, v1::ArmTarget>> stream_;
  mutable std::mutex mutex_;
  Vector3d tip_;
  Quaterniond rotation_;
  Vector3d residue_{0, 0, 0};
  v1::ArmTarget newest_, obeyed_;
  std::deque<v1::ArmTarget> queue_;
  std::atomic<double> fastest_{0};
  std::atomic<bool> flipped_{false};
  std::jthread reading_, reporting_;
};

// Sends its present command a hundred times a second.
class Hand {
 public:
  explicit Hand(std::unique_ptr<v1::Teleoperation::Stub> stub) : stub_(std::move(stub)) {
    context_.set_deadline(std::chrono::system_clock::now() + 3 * kLiveness);
    stream_ = stub_->Operate(&context_);
    reading_ = std::jthread([this] {
      v1::SlaveState state;
      while (stream_->Read(&state)) {
        const std::scoped_lock lock(mutex_);
        state_ = state;
      }
    });
    sending_ = std::jthread([this](const std::stop_token& stop) {
      Dice dice(9);
      for (std::uint64_t i = 1; !stop.stop_requested(); ++i) {
        v1::OperatorCommand command;
        {
          const std::scoped_lock lock(mutex_);
          command = command_;
        }
        command.set_sequence(i);
        ToProto(Clock::now(), command.mutable_sent_at());
        if (dice.Chance(0.5)) {
          for (double& number : *command.mutable_orientation()) number = -number;
        }
        if (!stream_->Write(command)) return;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
      }
    });
  }
  ~Hand() {
    sending_.request_stop();
    sending_.join();
    context_.TryCancel();
  }

  void Hold(std::uint32_t epoch, const Vector3d& p_M, const Quaterniond& R_M) {
    const std::scoped_lock lock(mutex_);
    command_.set_engaged(epoch > 0);
    if (epoch > 0) command_.set_epoch(epoch);
    ToProto(p_M, command_.mutable_p_m());
    ToProto(std::optional(R_M), command_.mutable_orientation());
  }
  [[nodiscard]] v1::SlaveState state() const {
    const std::scoped_lock lock(mutex_);
    return state_;
  }
  [[nodiscard]] bool Reaches(v1::Phase phase, std::uint32_t epoch) {
    return Eventually([&] { return state().phase() == phase && state().epoch() == epoch; });
  }

 private:
  std::unique_ptr<v1::Teleoperation::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::OperatorCommand, v1::SlaveState>> stream_;
  mutable std::mutex mutex_;
  v1::OperatorCommand command_;
  v1::SlaveState state_;
  std::jthread reading_, sending_;
};

Scene Streamed() {
  Scene scene = LoadScene(
      SourcePath("/deploy/scenes/silicone-block.yaml"),
      {"model.elements=60", "manipulator.source=stream", "manipulator.max_angular_speed=2 rad/s",
       "operator.rotation=[30 deg, -20 deg, 70 deg]"});
  // Long, so that a busy machine does not count as a silent driver or operator.
  scene.manipulator.silence = 60;
  scene.link.dead_after = scene.manipulator.blind_after = 60;
  return scene;
}

class SixAxisArmTest : public testing::Test {
 protected:
  std::unique_ptr<v1::Teleoperation::Stub> Connect() const {
    grpc::ChannelArguments arguments;
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
    return v1::Teleoperation::NewStub(grpc::CreateCustomChannel(
        server_->address(), grpc::InsecureChannelCredentials(), arguments));
  }
  std::uint32_t DegreesOfFreedom() const {
    grpc::ClientContext context;
    v1::SceneDescription scene;
    EXPECT_TRUE(Connect()->GetScene(&context, {}, &scene).ok());
    return scene.capabilities().degrees_of_freedom();
  }
  bool IsDriven() const {
    return Eventually([&] {
      const SlaveStatus status = slave_->Status();
      return status.arm && status.arm->fault.empty() && status.arm->reports > 3;
    });
  }

  const Scene scene_ = Streamed();
  const Vector3d home_ = scene_.manipulator.home;
  const std::unique_ptr<Slave> slave_ = MakeLiveSlave(scene_);
  const std::unique_ptr<Server> server_ = std::make_unique<Server>(*slave_, "127.0.0.1:0", false);
  const Quaterniond R_S0_{AngleAxisd(0.8, Vector3d(1, -2, 0.5).normalized())};
  const Quaterniond R_M0_{AngleAxisd(-1.1, Vector3d(0.3, 1, 1).normalized())};
};

// Reference: R_S_tool = R_SM R_M(t) R_M(0)^T R_SM^T R_S_tool(0), R_S_tool(0) the arm's own.
TEST_F(SixAxisArmTest, TheToolFollowsTheDevicesRotationWithinTheArmsResolution) {
  Arm arm(Connect(), home_, R_S0_);
  ASSERT_TRUE(IsDriven());
  EXPECT_EQ(DegreesOfFreedom(), 6U);
  Hand hand(Connect());
  hand.Hold(1, {0, 0, 0}, R_M0_);
  ASSERT_TRUE(hand.Reaches(v1::PHASE_FOLLOWING, 1));
  EXPECT_LT(arm.rotation().angularDistance(R_S0_), kWithin);
  const Eigen::Matrix3d& R_SM = scene_.operator_options.transform.R_SM;
  const auto wanted = [&](const Quaterniond& from, const Quaterniond& R_M,
                          const Quaterniond& R_M_begin) {
    return Quaterniond(R_SM * (R_M * R_M_begin.conjugate()).toRotationMatrix() * R_SM.transpose() *
                       from.toRotationMatrix());
  };
  std::uint32_t epoch = 1;
  Quaterniond from = R_S0_;
  // The last rotation passes half a turn, so its angle is negative.
  for (const double angle : {0.3, 1.4, 2.9, -2.8}) {
    const Quaterniond R_M = AngleAxisd(angle, Vector3d(2, 1, -1).normalized()) * R_M0_;
    hand.Hold(epoch, {0, 0, 0}, R_M);
    EXPECT_TRUE(Eventually([&] {
      if (hand.state().phase() ==
          v1::PHASE_HOLD) {  // a busy machine: engaged again, as by a person
        hand.Hold(++epoch, {0, 0, 0}, R_M0_);
        if (!hand.Reaches(v1::PHASE_FOLLOWING, epoch)) return false;
        from = arm.rotation();
        hand.Hold(epoch, {0, 0, 0}, R_M);
      }
      return arm.rotation().angularDistance(wanted(from, R_M, R_M0_)) < kWithin;
    })) << angle
        << ": " << arm.rotation().angularDistance(wanted(from, R_M, R_M0_)) << " rad off";
  }
  // The clutch is open: the device rotates back, the arm stays; engaged again, it continues from
  // there.
  const Quaterniond held = arm.rotation();
  hand.Hold(0, {0.01, 0, 0}, R_M0_);
  ASSERT_TRUE(hand.Reaches(v1::PHASE_CLUTCHED, epoch));
  hand.Hold(++epoch, {0.01, 0, 0}, R_M0_);
  ASSERT_TRUE(hand.Reaches(v1::PHASE_FOLLOWING, epoch));
  ASSERT_TRUE(Eventually([&, before = hand.state().command_sequence()] {
    return hand.state().command_sequence() > before + 30;
  }));
  EXPECT_LT(arm.rotation().angularDistance(held), kWithin) << "clutching turned the tool";
  const Quaterniond R_M = AngleAxisd(0.5, Vector3d::UnitX()) * R_M0_;
  hand.Hold(epoch, {0.01, 0, 0}, R_M);
  const Quaterniond goal = wanted(held, R_M, R_M0_);
  EXPECT_TRUE(Eventually([&] { return arm.rotation().angularDistance(goal) < 2 * kWithin; }));
  EXPECT_LT(arm.fastest(), kMaxAngularSpeed * (1 + 1e-3));
  EXPECT_GT(arm.fastest(), 0.5 * kMaxAngularSpeed);
  EXPECT_FALSE(arm.flipped()) << "a target changed sign";
}

}  // namespace
}  // namespace palpate
