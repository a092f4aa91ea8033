#include "slave/pipeline/fingertips/finger_local_model.h"

#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/slave/pipeline/fingertips/tactile_scene.h"
#include "tests/support/stop_after.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using namespace testing_fakes;

// A fingertip flat on the middle of the cube's top, pressed in by `depth`.
class FingerLocalModelTest : public ::testing::Test {
 protected:
  [[nodiscard]] Isometry3d Pressed(double depth) const {
    Isometry3d X_SF = scene_.sense.Find<Tactile>()->fingers.front().X_SF;
    X_SF.translation().z() -= depth;
    return X_SF;
  }
  // The model of small strain alone at this depth, normal force [N].
  double Modelled(double depth) {
    FingerLocalModel touch(scene_);
    LocalModel model;
    touch.Update(*body_, Isometry3d::Identity(), Pressed(depth), true, std::nullopt, &model);
    return depth * model.stiffness(2, 2);
  }
  // What `ratio` comes to after `samples` in which the force felt is `force` along the normal.
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

TEST_F(FingerLocalModelTest, TheBodyStopsWhileItIsMade) {
  StopAfter never(1000);
  MakeTactileBody(scene_, &never);
  ASSERT_FALSE(never.told().empty());
  for (std::size_t i = 0; i < never.told().size(); ++i) {
    StopAfter stop(static_cast<int>(i));
    EXPECT_THROW(MakeTactileBody(scene_, &stop), Interrupted);
  }
}

// A sample cannot wait for Green's functions. Beyond 400 nodes of the surface they are computed
// when they are first needed: those of the first touch are needed before.
TEST_F(FingerLocalModelTest, WhatTheFirstTouchNeedsIsComputedBeforehand) {
  const auto cache =
      std::filesystem::temp_directory_path() / ("first-touch-" + std::to_string(getpid()));
  Scene scene = CubeScene("patch: 12 mm, " + kAbove, "kind: fem-zone");
  std::get<BoxGeometry>(scene.object.geometry).cells = {10, 10, 10};
  const auto body = MakeTactileBody(scene);
  scene.model.cache = cache;
  const auto kept = MakeTactileBody(scene);
  std::filesystem::remove_all(cache);
  const auto under = body->contact->Find({0.02, 0.02, 0.047}, 0.1);
  ASSERT_TRUE(under);
  EXPECT_TRUE(body->stiffness->Knows(under->triangle));
  const auto far = body->contact->Find({0.002, 0.002, 0.047}, 0.1);
  ASSERT_TRUE(far);
  EXPECT_FALSE(body->stiffness->Knows(far->triangle));
  // With a folder for it, the whole surface is prepared for a contact of the fingertip's width.
  EXPECT_GT(kept->info().memory_bytes, 3 * body->info().memory_bytes / 2);
}

constexpr double kDepth = 2e-3;      // [m]
constexpr double kFullDepth = 5e-3;  // [m], of scenes that tell none

// Reference: the force felt itself. Half a second is ten learning times: e^-10 = 5e-5 is left.
TEST_F(FingerLocalModelTest, TheRenderedForceBecomesTheOneFelt) {
  const double modelled = Modelled(kDepth);
  ASSERT_GT(modelled, 0);
  EXPECT_NEAR(Learnt(kDepth, 1.7 * modelled, 0, 50), 1.7, 1e-4);
  EXPECT_NEAR(model_.force.z() + kDepth * model_.stiffness(2, 2), 1.7 * modelled, 1e-4 * modelled);
}

// Reference: the force felt itself, which leans by a tenth. Five learning times leave e^-5 =
// 0.7 % of that. What pulls sideways is a spring's, too: symmetric.
TEST_F(FingerLocalModelTest, TheRenderedForceLeansAsTheOneFelt) {
  const double along = Modelled(kDepth);
  const Vector3d felt = along * Vector3d(0.1, -0.05, 1);
  for (int i = 0; i < 100 * kFullDepth / kDepth; ++i) {
    touch_.Update(*body_, Isometry3d::Identity(), Pressed(kDepth), true,
                  FingerLocalModel::MeasuredForce{felt, 0}, &model_);
  }
  const Vector3d rendered = model_.force + model_.stiffness * Vector3d(0, 0, kDepth);
  EXPECT_LT((rendered - felt).norm(), 0.01 * felt.norm());
  EXPECT_EQ(model_.stiffness, model_.stiffness.transpose().eval());
  EXPECT_TRUE(touch_.HasOutgrownPatch());
  SurfacePatch patch;
  ASSERT_TRUE(touch_.MakePatch(*body_, Isometry3d::Identity(), Pressed(kDepth), &patch));
  EXPECT_FALSE(touch_.HasOutgrownPatch());
  touch_.Forget();
  touch_.Update(*body_, Isometry3d::Identity(), Pressed(kDepth), true, std::nullopt, &model_);
  EXPECT_LT(std::abs(model_.stiffness(0, 2)), 0.01 * model_.stiffness(2, 2));
}

TEST_F(FingerLocalModelTest, WhatWasFeltStaysForTheNextContact) {
  const double modelled = Modelled(kDepth);
  Learnt(kDepth, 2 * modelled, 0, 50);
  for (int i = 0; i < 20; ++i) {
    touch_.Update(*body_, Isometry3d::Identity(), Pressed(-1e-3), false, std::nullopt, &model_);
  }
  touch_.Update(*body_, Isometry3d::Identity(), Pressed(kDepth), true, std::nullopt, &model_);
  EXPECT_NEAR(touch_.force_ratio(), 2, 1e-4);
  touch_.Forget();
  EXPECT_DOUBLE_EQ(touch_.force_ratio(), 1);
}

// Foam gives way more the deeper it is pressed: one ratio for all depths would be a compromise.
// Reference: the forces felt, at both depths in turn; 0.2 of the difference is what each takes off
// the other's between its turns.
TEST_F(FingerLocalModelTest, EachDepthHasItsOwnRatio) {
  const double deep = 4 * kDepth / 2, shallow = kDepth / 2;
  const double at_shallow = Modelled(shallow), at_deep = Modelled(deep);
  for (int turn = 0; turn < 20; ++turn) {
    Learnt(shallow, 1.5 * at_shallow, 0, 5);
    Learnt(deep, 0.9 * at_deep, 0, 5);
  }
  touch_.Update(*body_, Isometry3d::Identity(), Pressed(shallow), true, std::nullopt, &model_);
  EXPECT_NEAR(touch_.force_ratio(), 1.5, 0.2 * 0.6);
  touch_.Update(*body_, Isometry3d::Identity(), Pressed(deep), true, std::nullopt, &model_);
  EXPECT_NEAR(touch_.force_ratio(), 0.9, 0.2 * 0.6);
  EXPECT_NEAR(model_.force.z() + deep * model_.stiffness(2, 2), touch_.force_ratio() * at_deep,
              1e-9 * at_deep);
}

}  // namespace
}  // namespace palpate
