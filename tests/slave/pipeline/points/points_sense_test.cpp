#include "slave/pipeline/points/points_sense.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <thread>

#include <gtest/gtest.h>

#include "shared/wire/enum_names.h"
#include "slave/live/live_slave.h"
#include "tests/slave/pipeline/points/watched_membrane.h"
#include "tests/support/engaged_hand.h"
#include "tests/support/eventually.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing_fakes::MembraneEnvironment;
using testing_fakes::MembraneSource;
using testing_fakes::WatchedMembraneScene;

std::unique_ptr<Slave> Watching(const Scene& scene,
                                std::shared_ptr<MembraneEnvironment> environment) {
  return std::make_unique<LiveSlave>(
      scene, MakeManipulator(scene),
      std::make_unique<PointsSense>(scene,
                                    std::make_unique<MembraneSource>(std::move(environment))));
}

// The slave over a fake source whose images the test draws.
class PointsSenseTest : public ::testing::Test {
 protected:
  PointsSenseTest() {
    environment_->Show({});
    Scene scene = WatchedMembraneScene();
    scene.manipulator.blind_after = 60;  // the operator moves on while images fail
    slave_ = Watching(scene, environment_);
    Until(IsValid);
  }

  SlaveState Until(const std::function<bool(const SlaveState&)>& reached) {
    SlaveState state;
    EXPECT_TRUE(Eventually([&] {
      state = slave_->Compose(Clock::now());
      return reached(state);
    })) << "not reached: "
        << ToString(state.validity);
    return state;
  }
  // Returns a state with a force from images taken after `since`.
  SlaveState UntilForce(double least) {
    return Until([&](const SlaveState& s) { return s.force && s.force->norm() > least; });
  }
  // Waits until the images show that the contact has ended.
  void UntilLeft() {
    environment_->Show({});
    Until([](const SlaveState& s) { return IsValid(s) && !(s.depth > 0); });
  }
  static bool IsValid(const SlaveState& s) { return s.validity == Validity::kValid; }

  std::shared_ptr<MembraneEnvironment> environment_ = std::make_shared<MembraneEnvironment>();
  std::unique_ptr<Slave> slave_;
};

// Reference: the plate's closed form, which bent the drawn dots. Tolerance: 1 mm of deflection is
// measured to within 0.02 mm by 31 dots together.
TEST_F(PointsSenseTest, APressIsEstimatedSeenAndShown) {
  slave_->TakeEvents();
  constexpr double kForce = 4.0;
  environment_->Show({kForce, {0.012, 0.004}, false});
  const SlaveState state = UntilForce(0.5 * kForce);
  ASSERT_TRUE(state.force);
  EXPECT_EQ(state.validity, Validity::kValid) << ToString(state.check);
  EXPECT_NEAR(state.force->z(), kForce, 0.05 * kForce);  // the object pushes the tool out
  EXPECT_LT(state.force->head<2>().norm(), 1e-9);
  EXPECT_GT(state.sigma, 0);
  EXPECT_LT(state.sigma, 0.2 * kForce);
  EXPECT_FALSE(state.true_force.has_value());
  EXPECT_TRUE(slave_->TakeEvents().Has(Event::kContact));
  const BoundaryShape shape = slave_->Shape({.nodal_forces = true, .field = true});
  ASSERT_EQ(shape.positions.size(), shape.rest.size());
  double deepest = 0;
  for (std::size_t i = 2; i < shape.rest.size(); i += 3) {
    deepest = std::min<double>(deepest, shape.positions[i] - shape.rest[i]);
  }
  EXPECT_NEAR(deepest, -testing_fakes::PlateDeflection(kForce, {0.012, 0.004}, {0.012, 0.004}),
              4e-5);
  ASSERT_TRUE(shape.field);
  EXPECT_EQ(shape.field->triangles, shape.elements);
  ASSERT_EQ(shape.field->displacement.size(), shape.rest.size());
  EXPECT_EQ(shape.field->image.size(), 2 * shape.rest.size() / 3);
  EXPECT_NEAR(*std::ranges::min_element(shape.field->displacement), deepest, 1e-6);
  EXPECT_TRUE(std::ranges::all_of(shape.field->image, [](float p) { return std::isfinite(p); }));
}

// The source sends no images while the operator presses.
TEST_F(PointsSenseTest, TheLocalModelFollowsTheHandBetweenImages) {
  slave_->BeginOperating();
  EngagedHand hand(slave_.get());
  const SlaveState home =
      Until([&](const SlaveState&) { return hand.Stay().phase == Phase::kFollowing; });
  EXPECT_FALSE(home.local_model.in_contact);
  const Vector3d normal = home.local_model.normal;
  EXPECT_NEAR(normal.z(), 1, 1e-6);
  environment_->FallSilent();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));  // images in transit arrive
  const Time last = slave_->Compose(Clock::now()).sensed_at;
  // Sideways by 10 mm and 0.3 mm deep, in small steps.
  const double height = normal.dot(home.p_S_tip - home.local_model.reference);
  const Vector3d way(0.010, 0, -height - 0.0003);
  const SlaveState deep = Until([&](const SlaveState& s) {
    hand.GoTo(home.p_S_tip + way, 2e-5);
    return s.local_model.in_contact && s.local_model.reference.x() > 0.0099;
  });
  EXPECT_EQ(deep.sensed_at, last);
  EXPECT_GT(normal.dot(deep.local_model.stiffness * normal), 100);
  slave_->EndOperating();
}

// A contact would become part of the rest shape, and would no longer be estimated.
TEST_F(PointsSenseTest, AResetIsRefusedWhileTheObjectIsPressedAndTakesTheRestFrameAgain) {
  environment_->Show({4.0, {0, 0}, false});
  UntilForce(1.0);
  EXPECT_THROW(slave_->Reset(slave_->Status().stops), std::logic_error);
  EXPECT_GT(Until(IsValid).force->norm(), 1.0);
  UntilLeft();
  slave_->Reset(slave_->Status().stops);
  environment_->Show({4.0, {0, 0}, false});
  EXPECT_GT(UntilForce(1.0).force->norm(), 1.0);
}

TEST_F(PointsSenseTest, ASourceThatBreaksIsAnAlarm) {
  environment_->Break();
  Until([&](const SlaveState&) { return !slave_->Status().alarms.empty(); });
  EXPECT_EQ(slave_->Status().alarms.front(), "the cable is off");
}

TEST(PointsSenseStartTest, ImagesThatAreNotTheRigsAreRefused) {
  auto environment = std::make_shared<MembraneEnvironment>();
  environment->Show({});
  Scene scene = WatchedMembraneScene();
  scene.sense.Find<StereoCameras>()->size = {320, 240};
  scene.sense.Find<StereoCameras>()->focal = 400;
  EXPECT_THROW(Watching(scene, environment), std::runtime_error);
  environment->End();
  EXPECT_THROW(Watching(WatchedMembraneScene(), environment), std::runtime_error);
}

}  // namespace
}  // namespace palpate
