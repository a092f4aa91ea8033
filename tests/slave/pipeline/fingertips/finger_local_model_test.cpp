#include "slave/pipeline/fingertips/finger_local_model.h"

#include <gtest/gtest.h>

#include "tests/slave/pipeline/fingertips/tactile_scene.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace testing_fakes;

// A fingertip flat on the centre of the cube's top, pressed in by `depth`.
class FingerLocalModelTest : public ::testing::Test {
 protected:
  [[nodiscard]] Isometry3d Pressed(double depth) const {
    Isometry3d X_SF = scene_.sense.Find<Tactile>()->fingers.front().X_SF;
    X_SF.translation().z() -= depth;
    return X_SF;
  }
  // Returns the normal force of the small-strain model at this depth [N].
  double Modelled(double depth) {
    FingerLocalModel touch(scene_);
    LocalModel model;
    touch.Update(*body_, Isometry3d::Identity(), Pressed(depth), true, std::nullopt, &model);
    return depth * model.stiffness(2, 2);
  }
  // Returns `ratio` after `samples` with an estimated force of `force` along the normal.
  double Learnt(double depth, double force, double sigma, int samples) {
    for (int i = 0; i < samples; ++i) {
      touch_.Update(*body_, Isometry3d::Identity(), Pressed(depth), true,
                    FingerLocalModel::MeasuredForce{{0, 0, force}, sigma}, &model_);
    }
    return touch_.force_ratio();
  }

  Scene scene_ = CubeScene(kAbove);
  std::unique_ptr<TactileBody> body_ = MakeTactileBody(scene_);
  FingerLocalModel touch_{scene_};
  LocalModel model_;
};

constexpr double kFingerDepth = 2e-3;  // [m]
constexpr double kFullDepth = 5e-3;    // [m], of scenes that state none

// Reference: the estimated force, which has a tangential part of a tenth. After five learning times
// e^-5 = 0.7 % of that is missing. The tangential stiffness is also that of a spring: symmetric.
TEST_F(FingerLocalModelTest, TheRenderedForceLeansAsTheOneEstimated) {
  const double along = Modelled(kFingerDepth);
  const Vector3d estimate = along * Vector3d(0.1, -0.05, 1);
  for (int i = 0; i < 100 * kFullDepth / kFingerDepth; ++i) {
    touch_.Update(*body_, Isometry3d::Identity(), Pressed(kFingerDepth), true,
                  FingerLocalModel::MeasuredForce{estimate, 0}, &model_);
  }
  const Vector3d rendered = model_.force + model_.stiffness * Vector3d(0, 0, kFingerDepth);
  EXPECT_LT((rendered - estimate).norm(), 0.01 * estimate.norm());
  EXPECT_EQ(model_.stiffness, model_.stiffness.transpose().eval());
  EXPECT_TRUE(touch_.HasOutgrownPatch());
  SurfacePatch patch;
  ASSERT_TRUE(touch_.MakePatch(*body_, Isometry3d::Identity(), Pressed(kFingerDepth), &patch));
  EXPECT_FALSE(touch_.HasOutgrownPatch());
  touch_.Forget();
  touch_.Update(*body_, Isometry3d::Identity(), Pressed(kFingerDepth), true, std::nullopt, &model_);
  EXPECT_LT(std::abs(model_.stiffness(0, 2)), 0.01 * model_.stiffness(2, 2));
}

TEST_F(FingerLocalModelTest, WhatWasEstimatedStaysForTheNextContact) {
  const double modelled = Modelled(kFingerDepth);
  Learnt(kFingerDepth, 2 * modelled, 0, 50);
  for (int i = 0; i < 20; ++i) {
    touch_.Update(*body_, Isometry3d::Identity(), Pressed(-1e-3), false, std::nullopt, &model_);
  }
  touch_.Update(*body_, Isometry3d::Identity(), Pressed(kFingerDepth), true, std::nullopt, &model_);
  EXPECT_NEAR(touch_.force_ratio(), 2, 1e-4);
  touch_.Forget();
  EXPECT_DOUBLE_EQ(touch_.force_ratio(), 1);
}

}  // namespace
}  // namespace palpate
