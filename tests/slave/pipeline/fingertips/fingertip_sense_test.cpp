#include "slave/pipeline/fingertips/fingertip_sense.h"

#include <functional>
#include <mutex>
#include <optional>
#include <thread>

#include <gtest/gtest.h>

#include "shared/wire/enum_names.h"
#include "slave/capture/tactile_inbox.h"
#include "slave/live/live_slave.h"
#include "slave/manipulator/simulated_manipulator.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"
#include "tests/support/engaged_hand.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using namespace testing_fakes;

// The state of the fingertips, which the test shares with its source.
struct TouchingSlave {
  std::mutex mutex;
  Hand hand{1};
  bool ended = false, silent = false, breaks = false;
  std::optional<Eigen::Isometry3d> X_SF = {};  // of the first fingertip, if reported
};

// A sample every 2 ms. The electrodes have a count of noise, because electrodes without noise are
// flagged.
class FakeSource final : public TactileSource {
 public:
  explicit FakeSource(std::shared_ptr<TouchingSlave> environment)
      : environment_(std::move(environment)) {}
  std::optional<TactileFrame> Next(const std::stop_token& stop) override {
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      const std::lock_guard lock(environment_->mutex);
      if (environment_->breaks) throw std::runtime_error("the cable is off");
      if (environment_->ended) return std::nullopt;
      if (environment_->silent) continue;
      TactileFrame frame = environment_->hand.Next();
      frame.sensed_at = Clock::now();
      frame.fingers[0].X_SF = environment_->X_SF;
      is_odd_ = !is_odd_;
      for (float& counts : frame.fingers[0].channels) counts += is_odd_ ? 1.0F : 0.0F;
      return frame;
    }
    return std::nullopt;
  }
  [[nodiscard]] std::string description() const override { return "a fake"; }

 private:
  std::shared_ptr<TouchingSlave> environment_;
  bool is_odd_ = false;
};

class FingertipSenseTest : public ::testing::Test {
 protected:
  FingertipSenseTest()
      : slave_(CubeScene(kAbove), MakeManipulator(CubeScene(kAbove)),
               std::make_unique<FingertipSense>(
                   CubeScene(kAbove), std::make_unique<FakeSource>(environment_), Fakes())) {}

  void Touch(const Vector3d& force_F, bool active) {
    const std::lock_guard lock(environment_->mutex);
    environment_->hand.forces_F[0] = force_F;
    environment_->hand.active[0] = active;
  }
  void Set(bool TouchingSlave::*what) {
    const std::lock_guard lock(environment_->mutex);
    (*environment_).*what = true;
  }
  SlaveState Until(const std::function<bool(const SlaveState&)>& reached) {
    SlaveState state;
    EXPECT_TRUE(Eventually([&] {
      state = slave_.Compose(Clock::now());
      return reached(state);
    })) << "not reached: "
        << ToString(state.validity);
    return state;
  }
  static bool IsValid(const SlaveState& s) { return s.validity == Validity::kValid; }
  static bool Touches(const SlaveState& s) { return s.local_model.in_contact; }

  std::shared_ptr<TouchingSlave> environment_ = std::make_shared<TouchingSlave>();
  LiveSlave slave_;
};

TEST_F(FingertipSenseTest, ATouchIsEstimatedAndSeen) {
  Until(IsValid);
  slave_.TakeEvents();
  Touch({0, 0, -0.2}, true);
  const SlaveState state =
      Until([](const SlaveState& s) { return s.force && s.force->z() > 0.19 && Touches(s); });
  EXPECT_EQ(state.validity, Validity::kValid);
  EXPECT_TRUE(slave_.TakeEvents().Has(Event::kContact));
  const BoundaryShape shape = slave_.Shape({.nodal_forces = true});
  EXPECT_NE(shape.positions, shape.rest);
  EXPECT_FALSE(slave_.Image(true, 80).has_value());
}

TEST_F(FingertipSenseTest, TheHandMovesTheFingertip) {
  Until(IsValid);
  slave_.BeginOperating();
  const Vector3d home = slave_.Compose(Clock::now()).p_S_tip;
  EngagedHand hand(&slave_);
  const SlaveState state = Until([&](const SlaveState&) {
    const SlaveState now = hand.GoTo(home + Vector3d(0, 0, 0.005), 1e-4);
    return (now.p_S_tip - home).norm() > 0.0049;
  });
  EXPECT_NEAR(state.local_model.Penetration(state.p_S_tip), -0.005, 2e-4);
  EXPECT_THROW(slave_.SetModel({"fem-green"}), std::logic_error);
  slave_.EndOperating();
}

TEST_F(FingertipSenseTest, SilenceIsStaleAndAnEndIsAnAlarm) {
  Until(IsValid);
  Set(&TouchingSlave::silent);
  const SlaveState stale =
      Until([](const SlaveState& s) { return s.validity == Validity::kStale; });
  EXPECT_GT(SecondsBetween(stale.sensed_at, Clock::now()), 0.06);
  Set(&TouchingSlave::ended);
  Until([&](const SlaveState&) { return !slave_.Status().alarms.empty(); });
}

TEST_F(FingertipSenseTest, TheModelAndItsModulusChangeWhileItFeels) {
  Until(IsValid);
  const double before = slave_.Compose(Clock::now()).local_model.stiffness.norm();
  ParameterChange softer;
  softer.young_modulus = 2000;
  slave_.SetParameters(softer);
  const SlaveState state = Until([&](const SlaveState& s) {
    return s.local_model.stiffness.norm() < 0.51 * before && IsValid(s);
  });
  EXPECT_NEAR(state.local_model.stiffness.norm() / before, 0.5, 1e-6);
  slave_.SetModel({"fem-green"});
  EXPECT_EQ(slave_.Describe().sense.model.kind, "fem-green");
  EXPECT_TRUE(slave_.TakeEvents().Has(Event::kModelChanged));
  EXPECT_THROW(slave_.SetModel({"bem2d"}), std::invalid_argument);
  slave_.SetModel({"fem"});
  EXPECT_EQ(slave_.Describe().sense.model.kind, "fem");
  ParameterChange absurd;
  absurd.young_modulus = -1;
  EXPECT_THROW(slave_.SetParameters(absurd), std::invalid_argument);
}

class CarryingArm final : public SimulatedManipulator {
 public:
  using SimulatedManipulator::SimulatedManipulator;
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
};

// The measured pose and the arm's encoders disagree by 2 mm. Reference: the sensed tip. The clutch
// must use it, or the master meets the surface 2 mm off.
TEST(FingertipSenseRegistrationTest, EngagingStartsAtTheSensedFingertip) {
  const Scene scene = CubeScene(kAbove);
  auto touching = std::make_shared<TouchingSlave>();
  touching->X_SF = scene.sense.Find<Tactile>()->fingers.front().X_SF;
  touching->X_SF->translation().x() += 2e-3;
  LiveSlave slave(
      scene, std::make_unique<CarryingArm>(scene.manipulator),
      std::make_unique<FingertipSense>(scene, std::make_unique<FakeSource>(touching), Fakes()));
  ASSERT_TRUE(Eventually([&] { return slave.Status().frames >= 20; }));
  slave.BeginOperating();
  OperatorCommand command;
  command.epoch = 1;
  command.sequence = 1;
  command.engaged = true;
  command.sent_at = Clock::now();
  EXPECT_TRUE(slave.Command(command));
  const SlaveState state = slave.Compose(Clock::now());
  EXPECT_NEAR(state.p_S_tip.x() - scene.manipulator.home.x(), 2e-3, 1e-9);
  EXPECT_LT((state.offset - state.p_S_tip).norm(), 10e-6);
}

}  // namespace
}  // namespace palpate
