#include <string>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using namespace testing_fakes;

// The plane is known before contact: the sphere crosses it when its centre is one radius above the
// surface, for any direction of the fingertip. Reference: the position of the apex.
TEST(TactileEstimatorTest, ThePlaneIsKnownBeforeContactFromEveryDirection) {
  for (const double degrees : {0.0, 35.0, 80.0}) {
    Touching t(CubeScene("pose: {translation: [20 mm, 20 mm, 55 mm], rotation: [0, " +
                         std::to_string(degrees) + " deg, 0]}"));
    const LocalModel& local = t.estimator.estimate().local_model;
    ASSERT_TRUE(local.known()) << degrees;
    EXPECT_FALSE(local.in_contact);
    EXPECT_NEAR((local.normal - Vector3d::UnitZ()).norm(), 0, 1e-12);
    // 15 mm from the centre of the sphere to the top, of which 7 mm are the radius.
    EXPECT_NEAR(local.Penetration(t.scene.manipulator.home), -0.008, 1e-12) << degrees;
    EXPECT_NEAR(local.Penetration(t.scene.manipulator.home - Vector3d(0, 0, 0.010)), 0.002, 1e-12);
    EXPECT_EQ(local.force, Vector3d(0, 0, 0));
    const Eigen::Matrix3d& K = local.stiffness;
    EXPECT_EQ(K, K.transpose().eval());
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(K).eigenvalues().minCoeff(), 0);
  }
}

// A bonded contact keeps its reference while the fingertip shears it; a frictionless one follows.
TEST(TactileEstimatorTest, ABondedContactKeepsItsReferenceAFrictionlessFollows) {
  for (const char* law : {"bonded", "frictionless"}) {
    Touching t(CubeScene(kAbove, std::string("kind: fem-green, contact: ") + law));
    t.Estimate(1, {0, 0, 0.001});
    t.Estimate(1, {0, 0, -0.002});
    const Vector3d before = t.estimator.estimate().local_model.reference;
    t.Estimate(1, {0.003, 0, -0.002});
    const LocalModel& after = t.estimator.estimate().local_model;
    const double moved = std::string(law) == "bonded" ? 0 : 0.003;
    EXPECT_NEAR((after.reference - before - Vector3d(moved, 0, 0)).norm(), 0, 1e-9) << law;
    if (moved > 0) {
      EXPECT_NEAR((after.stiffness * Vector3d::UnitX()).norm(), 0, 1e-9);
    }
  }
}

}  // namespace
}  // namespace palpate
