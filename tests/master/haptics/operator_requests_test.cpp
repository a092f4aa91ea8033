// Requests of the operator during a session, each with a contact that holds the device.
#include "master/haptics/operator_requests.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "master/session/tick_text.h"
#include "tests/master/haptics/rig.h"

namespace palpate {
namespace {

using enum OperatorState;

constexpr double kSmooth = 0.2;  // [N/ms]

// A device 2 mm deep in a wall of 500 N/m: 1 N.
class OperatorRequestsTest : public testing::Test {
 protected:
  void SetUp() override {
    rig_.Run(puppet_, 0.05);
    rig_.Engage(puppet_, 0.05);
    ASSERT_EQ(rig_.state(), kFollowing);
    rig_.Glide(puppet_, {0, -0.006, 0});
    rig_.Run(puppet_, 0.1);
    ASSERT_NEAR(puppet_.force.y(), 1, 1e-9);
  }
  // Largest change of the force between two ticks in `seconds` [N].
  double LargestStep(double seconds) {
    Eigen::Vector3d last = puppet_.force;
    double largest = 0;
    rig_.Run(puppet_, seconds, [&](const TickRecord& tick) {
      largest = std::max(largest, (tick.chain.sent - last).norm());
      last = tick.chain.sent;
    });
    return largest;
  }

  Rig rig_{{}, RenderMode::kLocal, 3.3, kSmooth};
  Puppet puppet_;
};

TEST_F(OperatorRequestsTest, AnOpenClutchLetsGoWithoutAStepAndTheToolRests) {
  const Eigen::Vector3d tip = rig_.slave.tip();
  rig_.requests.clutched = true;
  EXPECT_LE(LargestStep(0.2), kSmooth);
  EXPECT_EQ(rig_.state(), kClutched);
  EXPECT_EQ(puppet_.force.norm(), 0);
  puppet_.reading.p_M += Eigen::Vector3d(0.02, 0.03, 0);
  rig_.Run(puppet_, 0.1);
  EXPECT_EQ(rig_.slave.tip(), tip);
  EXPECT_TRUE(rig_.loop.record().clutched);
}

TEST_F(OperatorRequestsTest, AClutchThatClosesEngagesAgainWithoutMovingTheTool) {
  const Eigen::Vector3d tip = rig_.slave.tip();
  const auto epoch = rig_.loop.record().epoch;
  rig_.requests.clutched = true;
  rig_.Run(puppet_, 0.1);
  puppet_.reading.p_M += Eigen::Vector3d(0.02, 0.03, 0);
  rig_.Run(puppet_, 0.1);
  rig_.requests.clutched = false;
  EXPECT_LE(LargestStep(0.2), kSmooth);
  EXPECT_EQ(rig_.state(), kFollowing);
  EXPECT_EQ(rig_.loop.record().epoch, epoch + 1);
  EXPECT_NEAR((rig_.slave.tip() - tip).norm(), 0, 1e-12);
}

TEST_F(OperatorRequestsTest, AnotherRenderingWaitsUntilNoForceIsRendered) {
  rig_.requests.render = RenderMode::kHold;
  rig_.Run(puppet_, 0.1);
  EXPECT_EQ(rig_.loop.record().render, RenderMode::kLocal);
  rig_.Release(puppet_, 0.1);
  EXPECT_EQ(rig_.loop.record().render, RenderMode::kHold);
  puppet_.reading.engaged = true;
  EXPECT_LE(LargestStep(0.2), kSmooth);
  EXPECT_EQ(rig_.state(), kFollowing);
}

TEST_F(OperatorRequestsTest, ALowerLimitCountsAtOnceWithoutAStepAndAHigherOneNever) {
  constexpr double kRounding = 1e-9;
  rig_.requests.force_limit = 0.4;
  EXPECT_LE(LargestStep(0.05), kSmooth + kRounding);
  EXPECT_NEAR(puppet_.force.norm(), 0.4, 1e-12);
  EXPECT_EQ(rig_.loop.record().force_limit, 0.4);
  rig_.requests.force_limit = 3;
  rig_.Run(puppet_, 0.05);
  EXPECT_NEAR(puppet_.force.norm(), 0.4, 1e-12);
  EXPECT_EQ(rig_.state(), kFollowing);
}

// A drift of 50 mN that the slave's sense has, in the air and in contact.
class TareTest : public testing::Test {
 protected:
  void SetUp() override {
    rig_.slave.falsify = [this](SlaveState* state) {
      if (state->force) *state->force += drift_;
      if (state->local_model.in_contact) state->local_model.force += drift_;
    };
    rig_.Run(puppet_, 0.1);
  }
  TareState RequestTare(double seconds = 0.4) {
    ++rig_.requests.tares;
    rig_.Run(puppet_, seconds);
    return rig_.loop.record().tare_state;
  }
  void Press() {
    rig_.Engage(puppet_, 0.1);
    rig_.Glide(puppet_, {0, -0.006, 0});
    rig_.Run(puppet_, 0.2);
  }

  Eigen::Vector3d drift_{0, 0.05, 0};
  Rig rig_;
  Puppet puppet_;
};

TEST_F(TareTest, RemovesTheDriftFromTheForceAndReportsIt) {
  EXPECT_EQ(RequestTare(), TareState::kDone);
  EXPECT_NEAR((rig_.loop.record().tare - drift_).norm(), 0, 1e-12);
  Press();
  EXPECT_NEAR(puppet_.force.y(), 1, 1e-9);
  EXPECT_NEAR(rig_.loop.record().chain.estimated.y(), 1, 1e-9);
  EXPECT_TRUE(rig_.loop.record().chain.reasons.Has(Reason::kTared));
}

// Zeroing is refused in each state in which it could hide a contact.
TEST_F(TareTest, RefusesForcesThatMayBeContacts) {
  drift_ = {0, 0.4, 0};  // of 3.3 N
  EXPECT_EQ(RequestTare(), TareState::kTooLarge);
  drift_ = {0, 0.05, 0};
  rig_.slave.validity = Validity::kExtrapolated;
  EXPECT_EQ(RequestTare(), TareState::kNotValid);
  rig_.slave.validity = Validity::kValid;
  Press();
  EXPECT_EQ(RequestTare(), TareState::kTouching);
  rig_.Glide(puppet_, {0, 0, 0});
  rig_.Run(puppet_, 0.1);
  EXPECT_EQ(RequestTare(), TareState::kFollowing);
  EXPECT_TRUE(rig_.loop.record().tare.isZero(0));
}

TEST_F(TareTest, AContactThatIsMadeMeanwhileIsNotTared) {
  EXPECT_EQ(RequestTare(0.05), TareState::kMeasuring);
  rig_.slave.falsify = [](SlaveState* state) { state->local_model.in_contact = true; };
  rig_.Run(puppet_, 0.3);
  EXPECT_EQ(rig_.loop.record().tare_state, TareState::kTouching);
}

}  // namespace
}  // namespace palpate
