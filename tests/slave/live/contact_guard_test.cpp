#include "slave/live/contact_guard.h"

#include <algorithm>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "tests/slave/live/operator_port_fixture.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

TEST_F(GuardedPortTest, AForceBeyondTheGuardHoldsUntilTheToolIsDrawnBack) {
  Use({.max_speed = 0.020, .force_guard = 2});
  const ContactState heavy = Pushing(2.1);
  Press(0.1, Pushing(1.9));
  EXPECT_EQ(phase(), Phase::kFollowing);
  Press(0.004, heavy);
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_TRUE(guarded_->TakeEvents().Has(Event::kLimit));
  const double held = arm_.Tip().y();
  epoch_ = 2;
  Press(0.1, heavy);
  EXPECT_NEAR(arm_.Tip().y(), held, 1e-5) << "no deeper";
  Send(Next({0, 0, 0}, true, 3));
  Send(Next({0, 0.002, 0}, true, 3));
  EXPECT_NEAR(arm_.Tip().y(), held + 0.002, 1e-5) << "back is free";
  EXPECT_EQ(phase(), Phase::kFollowing);
}

TEST_F(GuardedPortTest, ADepthBeyondTheGuardRetractsToTheSurfaceIfTheSceneRequestsIt) {
  Use({.max_speed = 0.020, .depth_guard = 2e-3, .guard_retracts = true});
  Press(0.1, Pushing(1, 1.9e-3));
  EXPECT_EQ(phase(), Phase::kFollowing);
  arm_.moves = false;  // the arm does not move yet
  const double deepest = arm_.Tip().y();
  Press(0.004, Pushing(1, 2.1e-3));
  EXPECT_EQ(phase(), Phase::kHold);
  EXPECT_NEAR(arm_.target.y(), deepest + 2.1e-3, 1e-5);
  const int holds = arm_.holds();
  epoch_ = 2;
  Press(0.02, Pushing(1, 2.1e-3));
  EXPECT_EQ(arm_.holds(), holds) << "it goes on back, whatever the operator says";
}

// Tremor of 0.3 mm peak to peak is less than the 0.4 mm that 20 mm/s gives in 20 ms.
TEST_F(GuardedPortTest, ATremblingHandDrawsTheToolOutOfAGuard) {
  Use({.max_speed = 0.020, .force_guard = 2});
  const ContactState heavy = Pushing(2.1);
  Press(0.004, heavy);
  const double held = arm_.Tip().y();
  epoch_ = 2;
  Send(Next({0, 0, 0}, true, 2));
  for (int k = 0; k < 100; ++k) {
    Send(Next({0, 1e-5 * k + (k % 2 == 0 ? 1.5e-4 : -1.5e-4), 0}, true, 2));
    EXPECT_GE(arm_.Tip().y(), held) << k;
    guarded_->Watch(now_ += Seconds(0.002), heavy);
  }
  EXPECT_EQ(phase(), Phase::kFollowing);
  EXPECT_GT(arm_.Tip().y(), held + 0.9e-3);
  Send(Next({0, -2e-3, 0}, true, 2));
  EXPECT_EQ(phase(), Phase::kHold) << "who presses on engages anew";
}

// An operator who stays near the guard's position would end an epoch with each tremor.
TEST_F(GuardedPortTest, AGuardEndsSlightlyBelowTheForceAtWhichItBegan) {
  Use({.max_speed = 0.020, .force_guard = 2});
  const auto feel = [this](double force) {
    Press(0.004, Pushing(force));
    return phase();
  };
  EXPECT_EQ(feel(2.01), Phase::kHold);
  epoch_ = 2;
  y_ = 0;
  for (const double force : {1.99, 2.01, 1.95, 2.05}) EXPECT_EQ(feel(force), Phase::kFollowing);
  EXPECT_EQ(feel(1.85), Phase::kFollowing);
  EXPECT_EQ(feel(2.01), Phase::kHold);
}

// Samples are late; the arm's position is not, so force and depth are also computed from it.
TEST_F(GuardedPortTest, TheForceOfTheLocalModelCountsToo) {
  Use({.max_speed = 0.020, .force_guard = 2, .depth_guard = 2e-3});
  ContactState contact = Pushing(0.5);
  contact.force_by_now = 1.9;
  contact.depth_by_now = 1.9e-3;
  Press(0.01, contact);
  EXPECT_EQ(phase(), Phase::kFollowing);
  contact.force_by_now = 2.1;
  Press(0.002, contact);
  EXPECT_EQ(phase(), Phase::kHold);
  epoch_ = 2;
  contact.force_by_now = 0;
  Press(0.01, contact);
  EXPECT_EQ(phase(), Phase::kFollowing);
  contact.depth_by_now = 2.1e-3;
  Press(0.002, contact);
  EXPECT_EQ(phase(), Phase::kHold);
}

// Between two checks the arm moves to the last commanded position. According to the local model
// this is never far beyond a guard: 2 mm, or 2 N at 1 N/mm.
TEST_F(GuardedPortTest, ALateCheckLetsTheToolGoLittleBeyondAGuard) {
  struct Case {
    ManipulatorOptions limits;
    double depth, force, way;  // [m], [N], [m]
  };
  const ManipulatorOptions by_depth{.max_speed = 0.020, .depth_guard = 2e-3};
  const ManipulatorOptions by_force{.max_speed = 0.020, .force_guard = 2};
  for (const Case& a : {Case{by_depth, 1e-3, 1, kFloor * 2e-3 - 1e-3},
                        Case{by_depth, -1e-3, 0, kFloor * 2e-3 + 1e-3},
                        Case{by_force, 1e-3, 1, kFloor * 2e-3 - 1e-3},
                        Case{by_force, -1e-3, 0, kFloor * 2e-3 + 1e-3}}) {
    sequence_ = 0;
    Use(a.limits);
    const Vector3d tip = arm_.Tip();
    guarded_->Watch(now_, {.force = Vector3d(0, a.force, 0),
                           .outward = Vector3d::UnitY(),
                           .depth_by_now = a.depth,
                           .normal = Vector3d::UnitY(),
                           .stiffness = 1000});
    for (const double down : {3.2e-3, 3.9e-3}) {
      EXPECT_TRUE(Send(Next({5e-4, -down, 0})));
      EXPECT_LT((arm_.Tip() - tip - Vector3d(5e-4, -a.way, 0)).norm(), 1e-12);
    }
    EXPECT_EQ(phase(), Phase::kFollowing);
    EXPECT_TRUE(Send(Next({0, 0, 0})));
    EXPECT_NEAR(arm_.Tip().y(), tip.y(), 1e-12) << "out is free";
  }
}

// An operator presses on at 20 mm/s and engages again before every motion. Samples are 50 ms old
// and 4 % off to either side, the local model is right. Reference: the spring, 1 N/mm, from y = 0.
TEST_F(GuardedPortTest, EngagementsDoNotAddUpBeyondAGuard) {
  constexpr double kSpring = 1000;
  for (const bool retracts : {false, true}) {
    sequence_ = 0;
    arm_.Place({0, 2e-3, 0});
    Use({.max_speed = 0.020, .force_guard = 2, .depth_guard = 3e-3, .guard_retracts = retracts});
    std::vector<double> depths;
    double deepest = 0, hand = 0;
    for (int step = 0; step < 2500; ++step) {
      const auto epoch = static_cast<std::uint32_t>(step) + 2;
      Send(Next({0, hand, 0}, true, epoch));
      hand -= 4e-5;
      Send(Next({0, hand, 0}, true, epoch));
      const double depth = -arm_.Tip().y();
      depths.push_back(std::max(0.0, depth));
      deepest = std::max(deepest, depth);
      const double old = depths[static_cast<std::size_t>(std::max(0, step - 25))];
      const double estimated = kSpring * old * (step % 10 < 5 ? 1.04 : 0.96);
      guarded_->Watch(now_ += Seconds(0.002), {.force = Vector3d(0, estimated, 0),
                                               .depth = old,
                                               .outward = Vector3d::UnitY(),
                                               .force_by_now = kSpring * depths.back(),
                                               .depth_by_now = depth,
                                               .normal = Vector3d::UnitY(),
                                               .stiffness = kSpring});
    }
    EXPECT_GT(kSpring * deepest, 1.9);
    EXPECT_LT(kSpring * deepest, kFloor * 2 + 1e-9);
  }
}

class RetreatTest : public GuardedPortTest {
 protected:
  RetreatTest() {
    Use({.max_speed = 0.020, .force_guard = 2, .guard_retracts = true});
    Press(0.1, light_);
    deepest_ = arm_.Tip().y();
  }
  void Watch(double seconds, const ContactState& contact) {
    for (double t = 0; t < seconds; t += 0.002) guarded_->Watch(now_ += Seconds(0.002), contact);
  }
  // Distance of the tool from its deepest position, outwards [m].
  double Out() const { return arm_.Tip().y() - deepest_; }
  void LetGo() { Send(Next({0, y_, 0}, false, epoch_)); }

  const ContactState light_ = Pushing(1), heavy_ = Pushing(2.1, 2e-3);
  double deepest_ = 0;
};

// An arm with a fault stops and forgets its target.
TEST_F(RetreatTest, AFaultDelaysItAndDoesNotBlockOperators) {
  arm_.faulty = true;
  arm_.moves = false;
  Watch(0.15, heavy_);
  EXPECT_NEAR(Out(), 0, 1e-9);
  arm_.faulty = false;
  arm_.moves = true;
  Watch(0.01, heavy_);
  EXPECT_NEAR(Out(), 2e-3, 1e-9);
  Watch(0.01, {Vector3d::Zero()});
  Send(Next({0, 0, 0}, true, 2));
  Send(Next({0, 0.001, 0}, true, 2));
  EXPECT_NEAR(Out(), 3e-3, 1e-9) << "whoever engages anew leads it";
}

// The new driver's origin is different: a position outside of the object for the last driver is 30
// mm deeper for this one.
TEST_F(RetreatTest, AnotherDriverIsNotLedByThePlacesOfTheLast) {
  arm_.moves = false;
  Watch(0.01, heavy_);
  arm_.faulty = true;
  Watch(0.05, heavy_);
  arm_.faulty = false;
  arm_.moves = true;
  ++arm_.driver;
  arm_.Place({0.01, 0.03, 0});
  Watch(1, heavy_);
  EXPECT_EQ(arm_.Tip().y(), 0.03);
  EXPECT_EQ(phase(), Phase::kHold);
}

TEST_F(RetreatTest, AnArmThatStopsOnTheRetreatDoesNotBlockOperators) {
  Press(0.002, heavy_);
  arm_.moves = false;
  arm_.Place({0.01, deepest_ + 1e-3, 0});
  Watch(3, heavy_);
  arm_.moves = true;
  Send(Next({0, 0, 0}, true, 2));
  Send(Next({0, 0.002, 0}, true, 2));
  EXPECT_EQ(phase(), Phase::kFollowing);
  EXPECT_NEAR(Out(), 3e-3, 1e-9);
}

TEST_F(RetreatTest, ItBeginsAlsoAfterTheHandWasReleased) {
  LetGo();
  Watch(0.03, heavy_);
  EXPECT_NEAR(Out(), 2e-3, 1e-9);
}

TEST_F(RetreatTest, ItBeginsWhenALateSampleShowsTheContact) {
  Press(0.02, {std::nullopt});
  Watch(2, {std::nullopt});
  EXPECT_NEAR(Out(), 0, 1e-4);
  Watch(0.03, heavy_);
  EXPECT_GT(Out(), 1.9e-3);
}

// The tool has been at rest, so the object has moved.
TEST_F(RetreatTest, AToolAtRestForLongIsLeftWhereItIs) {
  LetGo();
  Watch(0.5, light_);
  Watch(0.5, heavy_);
  EXPECT_NEAR(Out(), 0, 1e-9);
}

TEST_F(RetreatTest, TheEmergencyStopEndsIt) {
  arm_.moves = false;
  Press(0.002, heavy_);
  guarded_->EmergencyStop();
  arm_.moves = true;
  Watch(0.1, heavy_);
  guarded_->Reset(guarded_->stops());
  Watch(0.1, heavy_);
  EXPECT_NEAR(Out(), 0, 1e-4);
}

}  // namespace
}  // namespace palpate
