#include "slave/pipeline/fingertips/tactile_estimator.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "shared/state/driven_clock.h"
#include "slave/mechanics/factory/make_model.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace testing_fakes;

// Reference: the scene's model alone with the same force at the point under the pad.
TEST(TactileEstimatorTest, APressDeformsTheObjectAsItsForceDoes) {
  Touching t(CubeScene(kAbove));
  const Vector3d force(0.007, 0, -0.07), way(0, 0, -0.003);  // near the model's displacement
  const ContactEstimate& estimated = t.Press(force, way);
  EXPECT_EQ(estimated.validity, Validity::kValid);
  ASSERT_TRUE(estimated.force.has_value());
  EXPECT_NEAR((*estimated.force + force).norm(), 0, 1e-6);  // of the object on the fingertip
  EXPECT_TRUE(estimated.local_model.in_contact);
  EXPECT_NEAR((estimated.p_S_contact - Vector3d(0.02, 0.02, 0.04)).norm(), 0, 1e-9);
  EXPECT_NEAR(estimated.depth, 0.003, 1e-9);

  const auto model = MakeModel(t.scene, MeshObject(t.scene, std::nullopt));
  const Contact contact{
      .kind = Contact::Kind::kForce, .p_O = {0.02, 0.02, 0.04}, .prescribed_O = force};
  Solution solution;
  model->Solve({&contact, 1}, &solution);
  std::vector<Vector3d> u;
  model->Displacements(solution, &u);
  const std::vector<Vector3d> p = t.Nodes();
  ASSERT_EQ(p.size(), u.size());
  for (std::size_t i = 0; i < u.size(); ++i) {
    // The force is computed in float: 1e-6 N of 0.2 N, times 5 mm.
    EXPECT_NEAR((p[i] - t.estimator.body()->surface.nodes[i] - u[i]).norm(), 0, 2e-7) << i;
  }
  EXPECT_GT(t.LargestMove(), 1e-3);
}

// The cube with `cells` along each side and a fingertip with a fixed pose near the edge of the top,
// so that the contact lies beside the pad's centre.
Scene EccentricScene(int cells, const std::string& hold) {
  Scene scene =
      CubeScene("patch: 12 mm, hold: " + hold + ", pose: {translation: [32 mm, 20 mm, 47 mm]}",
                "kind: fem-green, tolerance: 50 %");
  scene.object.geometry = BoxGeometry{{0.04, 0.04, 0.04}, {cells, cells, cells}};
  return scene;
}

// Reference: the same press on twice as fine a mesh.
TEST(TactileEstimatorTest, TheMomentOfAContactIsWithin5PercentOfForceTimesWidth) {
  constexpr double kWidth = 0.012;
  const Vector3d force(0.02, 0, -0.2), way(0, 0, -0.002);
  for (const std::string hold : {"displacement", "force"}) {
    Touching coarse(EccentricScene(12, hold)), fine(EccentricScene(24, hold));
    const ContactEstimate& a = coarse.Press(force, way);
    const ContactEstimate& b = fine.Press(force, way);
    ASSERT_TRUE(a.force && a.moment && b.force && b.moment) << hold;
    EXPECT_LT((*a.moment - *b.moment).norm(), 0.05 * force.norm() * kWidth) << hold;
    EXPECT_GT(a.moment_sigma, (*a.moment - *b.moment).norm() / 3) << hold;
    // About the apex, where the contact is, only an uneven distribution causes a moment.
    const bool is_even = hold == "force";
    EXPECT_EQ(b.moment->norm() > 0.02 * force.norm() * kWidth, !is_even) << b.moment->norm();
  }
}

// Reference: the same press with everything rotated (equation 5): the poses of object and fingertip
// by R. The deformed nodes rotate with them; the network's output does not change.
TEST(TactileEstimatorTest, TheAnswerTurnsWithObjectAndFingertip) {
  Touching straight(CubeScene(kAbove));
  Scene scene = CubeScene(kAbove);
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.1, -0.2, 0.3);
  scene.object.X_SO = X * scene.object.X_SO;
  Finger& finger = scene.sense.Find<Tactile>()->fingers[0];
  finger.X_SF = X * finger.X_SF;
  scene.manipulator.home =
      finger.X_SF * Vector3d(0, 0, -scene.sense.Find<Tactile>()->finger_radius);
  Touching turned(scene);

  const Vector3d force(0.03, 0.01, -0.2), way(0, 0, -0.003);
  const ContactEstimate& a = straight.Press(force, way);
  const ContactEstimate& b = turned.Press(force, X.linear() * way);
  ASSERT_TRUE(a.force && b.force);
  EXPECT_NEAR((*b.force - X.linear() * *a.force).norm(), 0, 1e-9);
  const LocalModel &la = a.local_model, &lb = b.local_model;
  EXPECT_NEAR((lb.normal - X.linear() * la.normal).norm(), 0, 1e-9);
  EXPECT_NEAR((lb.reference - X * la.reference).norm(), 0, 1e-9);
  EXPECT_NEAR((lb.stiffness - X.linear() * la.stiffness * X.linear().transpose()).norm() /
                  la.stiffness.norm(),
              0, 1e-6);
  const auto pa = straight.Nodes(), pb = turned.Nodes();
  for (std::size_t i = 0; i < pa.size(); ++i) EXPECT_NEAR((pb[i] - X * pa[i]).norm(), 0, 1e-7);
}

TEST(TactileEstimatorTest, APoseInsideTheObjectIsFlagged) {
  for (const bool active : {true, false}) {
    Touching t(CubeScene(kAbove));
    t.hand.active[0] = active;
    t.hand.forces_F[0] = {0, 0, active ? -0.2 : 0.0};
    const ContactEstimate& estimated =
        t.Estimate(kWindow, {0, 0, -0.027});  // its centre at the cube's centre
    EXPECT_EQ(estimated.validity, Validity::kExtrapolated) << active;
    EXPECT_NE(t.estimator.finger(0).reason.find("inside"), std::string_view::npos) << active;
    EXPECT_EQ(t.LargestMove(), 0) << active;
    EXPECT_TRUE(estimated.local_model.stiffness.allFinite());
  }
}

// Only a very soft object deforms this much.
TEST(TactileEstimatorTest, APressDeeperThanAFingertipKeepsItsShape) {
  Touching t(CubeScene(kAbove));
  t.Press({0, 0, -0.2}, {0, 0, -0.003});
  const double pressed = t.LargestMove();
  EXPECT_GT(pressed, 1e-3);
  const ContactEstimate& estimated = t.Press({0, 0, -0.2}, {0, 0, -0.027});
  EXPECT_EQ(estimated.validity, Validity::kExtrapolated);
  EXPECT_EQ(estimated.check, FailedCheck::kPose);
  EXPECT_NEAR(t.LargestMove(), pressed, 1e-6);
  t.hand.active[0] = false;
  t.Estimate(kWindow, {0, 0, 0.02});
  EXPECT_LT(t.LargestMove(), 1e-12);
}

TEST(TactileEstimatorTest, RestValuesTakenInsideTheObjectAreFlaggedUntilTakenAgain) {
  Touching t(CubeScene("pose: {translation: [20 mm, 20 mm, 44 mm]}"));
  EXPECT_EQ(t.estimator.estimate().check, FailedCheck::kRestDrift);
  t.Estimate(kWindow, {0, 0, 0.02});
  EXPECT_EQ(t.estimator.estimate().check, FailedCheck::kRestDrift) << "lifted";
  t.estimator.Reset();
  t.Estimate(kRest + kWindow, {0, 0, 0.02});
  EXPECT_EQ(t.estimator.estimate().validity, Validity::kValid);
}

// The arm moves 0.5 mm per sample; the samples lag by four.
TEST(TactileEstimatorTest, AFingertipThatLagsBehindTheArmIsFlagged) {
  const Scene scene = CubeScene(kAbove);
  for (const int late : {0, 4}) {
    TactileEstimator estimator(scene, Fakes());
    Hand hand(1);
    for (int i = 0; i < 30; ++i) {
      const double way = 5e-4 * std::max(0, i - 12), shown = 5e-4 * std::max(0, i - 12 - late);
      TactileFrame frame = hand.Next();
      frame.fingers[0].X_SF = Isometry3d(scene.sense.Find<Tactile>()->fingers[0].X_SF);
      frame.fingers[0].X_SF->translation().z() += shown;
      estimator.Estimate(frame, scene.manipulator.home + Vector3d(0, 0, way), 0.45);
    }
    EXPECT_EQ(estimator.estimate().check, late > 0 ? FailedCheck::kArm : FailedCheck::kNone)
        << late;
  }
}

// E L^2 = 6.4 N is more than any strain gives. Below it the search for equilibrium may be long but
// ends.
TEST(TactileEstimatorTest, AnAbsurdForceIsFlaggedWithoutDelay) {
  for (const double newtons : {1e5, 7.0, 5.0, 2.0}) {
    Touching t(CubeScene(kAbove));
    const ContactEstimate& estimated = t.Press({0, 0, -newtons}, {0, 0, -0.003}, 0, 2 * kWindow);
    ASSERT_TRUE(estimated.force.has_value());
    const BoundaryShape shape = t.estimator.Shape({.nodal_forces = true});
    EXPECT_NE(Worse(estimated.validity, shape.validity), Validity::kValid) << newtons;
    for (const float x : shape.positions) ASSERT_TRUE(std::isfinite(x));
  }
}

// Law: if the pose is rotated by a small angle about an axis normal to the force, the force vector
// changes by angle times force.
TEST(TactileEstimatorTest, APoseThatIsNotQuiteKnownWidensSigma) {
  const Vector3d force(0, 0.02, -0.3);
  const auto sigma = [&](const std::string& tolerance) {
    Touching t(CubeScene("pose_tolerance: " + tolerance + ", " + kAbove));
    const ContactEstimate& estimated = t.Press(force, {0, 0, 0});
    EXPECT_EQ(t.estimator.finger(0).sigma, estimated.sigma);
    return estimated.sigma;
  };
  const double known = sigma("0 deg"), across = 0.05 * force.norm();
  EXPECT_GT(known, 0);
  EXPECT_NEAR(sigma("0.05 rad"), std::hypot(known, across, across), 1e-6);
}

// Reference: superposition, in the linear law: five fingertips together move every node by the sum
// of what each alone does, to rounding.
TEST(TactileEstimatorTest, FiveFingertipsAddUp) {
  const Scene scene = CubeScene(kFive, "kind: fem, law: linear");
  const std::vector<Vector3d> forces{
      {0, 0, -0.1}, {0.01, 0, -0.05}, {0, 0.01, -0.08}, {0, 0, -0.04}, {0.02, 0, -0.06}};
  Touching together(scene);
  std::vector<Vector3d> sum(together.estimator.body()->surface.nodes.size(), Vector3d::Zero());
  for (std::size_t i = 0; i < 5; ++i) {
    Touching alone(scene);
    alone.Press(forces[i], {0, 0, 0}, i);
    const auto p = alone.Nodes();
    for (std::size_t k = 0; k < p.size(); ++k) {
      sum[k] += p[k] - alone.estimator.body()->surface.nodes[k];
    }
    together.hand.forces_F[i] = forces[i];
    together.hand.active[i] = true;
  }
  const ContactEstimate& estimated = together.Estimate(kWindow);
  EXPECT_EQ(estimated.finger_count, 5);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_TRUE(estimated.fingers[i].in_contact) << i;
    EXPECT_EQ(estimated.fingers[i].validity, Validity::kValid) << i;
    ASSERT_TRUE(estimated.fingers[i].force.has_value()) << i;
    EXPECT_NEAR(estimated.fingers[i].force->norm(), forces[i].norm(), 1e-6) << i;
  }
  const auto p = together.Nodes();
  for (std::size_t k = 0; k < p.size(); ++k) {
    EXPECT_NEAR((p[k] - together.estimator.body()->surface.nodes[k] - sum[k]).norm(), 0, 1e-8);
  }
}

// Paper B, V and VI: soft contacts are missing in some samples, and the mesh oscillates; holding
// the contact nodes reduces this. The fingertip is 4 mm deep; its contact is missing for 8 of every
// 20 samples, longer than a contact is held. The remaining motion of the mesh is its range after
// the first second.
TEST(TactileEstimatorTest, HoldingTheContactCalmsTheOscillationOfIntermittentContacts) {
  const auto range = [](const std::string& hold) {
    Touching t(CubeScene(kAbove + ", hold: " + hold, "kind: fem, time: dynamic"));
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (int i = 0; i < 400; ++i) {
      t.hand.active[0] = i % 20 >= 8;
      t.hand.forces_F[0] = t.hand.active[0] ? Vector3d(0, 0, -0.2) : Vector3d(0, 0, 0);
      t.Estimate(1, {0, 0, -0.004});
      if (i < 100) continue;
      low = std::fmin(low, t.LargestMove());
      high = std::fmax(high, t.LargestMove());
    }
    return high - low;
  };
  const double by_force = range("force"), held = range("displacement");
  EXPECT_GT(by_force, 1e-3);
  EXPECT_LT(held, 0.02 * by_force);
}

// Law: Coulomb's. The hand presses, slides by more than the shear that friction bears, slides back,
// lifts, and presses again.
TEST(TactileEstimatorTest, AModelWithFrictionFollowsThePadAlongTheSurface) {
  const DrivenClock clock;  // no deadline ends a search
  constexpr double kFriction = 0.3;
  Scene scene =
      CubeScene("patch: 20 mm, hold: displacement, pose: {translation: [30 mm, 30 mm, 47 mm]}",
                "kind: fem, law: linear, residual: 1e-4, contact: friction, friction: 0.3");
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.04}, {10, 10, 6}};
  Touching t(scene);
  Vector3d way(0, 0, 0);
  const auto move_to = [&](double x, double z) -> Vector3d {
    const Vector3d from = way, to(x, 0, z);
    constexpr int kSamples = 8;
    for (int i = 1; i <= kSamples; ++i) {
      way = from + (to - from) * i / kSamples;
      t.Press({0, 0, z < 0 ? -0.2 : 0.0}, way, 0, 1);
    }
    const ContactResponse* response = t.estimator.object().ResponseOf(0);
    EXPECT_NE(t.estimator.object().validity(), Validity::kFailed)
        << t.estimator.body()->deformation->failure();
    return response != nullptr ? response->force_O : Vector3d(0, 0, 0);
  };
  const Vector3d pressed = move_to(0, -0.002);
  ASSERT_LT(pressed.z(), 0);
  EXPECT_LT(std::abs(pressed.x()), 0.05 * -pressed.z());
  const Vector3d slid = move_to(0.004, -0.002);
  EXPECT_NEAR(slid.x(), kFriction * -slid.z(), 0.03 * -slid.z()) << "drags the surface along";
  const Vector3d returned = move_to(0, -0.002);
  EXPECT_NEAR(returned.x(), -kFriction * -returned.z(), 0.03 * -returned.z());
  t.hand.active[0] = false;
  EXPECT_EQ(move_to(0, 0.003), Vector3d(0, 0, 0));
  EXPECT_LT(t.LargestMove(), 1e-12);
  t.hand.active[0] = true;
  const Vector3d again = move_to(0, -0.002);
  EXPECT_NEAR((again - pressed).norm(), 0, 0.02 * pressed.norm()) << "its history has ended";
}

// The network takes the mean over its window. If the force grows linearly, interpolating the right
// number of missing samples does not change that mean.
TEST(TactileEstimatorTest, AnEvenlyGrowingForceIsInterpolatedOverAMissingSample) {
  const Vector3d way(0, 0, -0.003);
  Touching whole(CubeScene(kAbove)), holed(CubeScene(kAbove));
  for (int i = 1; i <= 40; ++i) {
    for (Touching* t : {&whole, &holed}) {
      t->hand.forces_F[0] = {0, 0, -0.01 * i};
      t->hand.active[0] = true;
    }
    const ContactEstimate& expected = whole.Estimate(1, way);
    const TactileFrame frame = holed.hand.Next();
    if (i % 10 == 7) continue;
    const ContactEstimate& estimated =
        holed.estimator.Estimate(frame, holed.scene.manipulator.home + way);
    ASSERT_TRUE(estimated.force && expected.force) << i;
    EXPECT_NEAR(estimated.force->z(), expected.force->z(), 1e-6) << i;
  }
}

TEST(TactileEstimatorTest, FramesOfFiveFingertipsAllocateNothing) {
  Touching t(CubeScene(kFive));
  for (std::size_t i = 0; i < 5; ++i) {
    t.hand.forces_F[i] = {0, 0, -0.05};
    t.hand.active[i] = true;
  }
  const auto circle = [](int i) {
    const double angle = 2 * std::numbers::pi * i / 100;
    return Vector3d(0.004 * std::cos(angle), 0.004 * std::sin(angle), -0.001);
  };
  for (int i = 0; i < 100; ++i) t.Estimate(1, circle(i));
  const long before = AllocationCount();
  for (int i = 0; i < 300; ++i) t.Estimate(1, circle(i));
  EXPECT_EQ(AllocationCount() - before, 0);
}

}  // namespace
}  // namespace palpate
