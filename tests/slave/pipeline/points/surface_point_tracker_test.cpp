#include "slave/pipeline/points/surface_point_tracker.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/slave/pipeline/points/watched_membrane.h"
#include "tests/slave/vision/depth/depth_images.h"
#include "tests/slave/vision/texture/target_images.h"

namespace palpate {
namespace {

using testing_fakes::DotPairs;
using testing_fakes::WatchedMembraneScene;

TEST(SurfacePointTrackerTest, CoveredCamerasSeeNothingAndAResetTakesTheRestAgain) {
  const Scene scene = WatchedMembraneScene();
  const auto tracker = MakeSurfacePointTracker(scene, RigOf(scene));
  const StereoPair rest = DotPairs().Draw({}, 1);
  const StereoPair covered = DotPairs().Draw({0, {0, 0}, true}, 2);
  const StereoPair pressed = DotPairs().Draw({4.0, {0, 0}, false}, 3);
  while (!tracker->at_rest_known()) tracker->Process(rest);
  EXPECT_TRUE(tracker->Process(rest).found);
  EXPECT_FALSE(tracker->Process(covered).found);
  EXPECT_FALSE(tracker->Process(StereoPair{}).found);
  EXPECT_TRUE(tracker->Process(pressed).found);
  tracker->Reset();
  EXPECT_FALSE(tracker->at_rest_known());
  for (int i = 0; i <= tracker->rest_images(); ++i) tracker->Process(pressed);
  const SurfaceObservation& seen = tracker->Process(pressed);
  ASSERT_TRUE(seen.found);
  for (const SurfacePoint& point : seen.points) {
    EXPECT_LT((point.p_S - point.p_S_rest).norm(),
              5e-6);  // the same image, searched near the last places
  }
}

// Reference: the target's own motion, drawn by perspective alone. Tolerance: a window is found to
// 0.03 px, 1.84 mm / px in depth.
TEST(SurfacePointTrackerTest, TextureMeasuresTheMotionOfItsWindows) {
  TargetImages images;
  Scene scene;
  scene.sense.Set(PointsOptions{});
  scene.sense.Find<StereoCameras>()->X_SL = images.X_SL;
  scene.sense.Find<PointTracking>()->track = PointTracking::Track::kTexture;
  scene.sense.Find<PointTracking>()->count = 12;
  const auto tracker = MakeSurfacePointTracker(scene, images.rig);
  EXPECT_EQ(tracker->stage(), "texture");
  EXPECT_FALSE(tracker->Process(StereoPair{}).found);
  EXPECT_FALSE(tracker->at_rest_known());
  const auto look = [&](const Eigen::Vector3d& p_S, std::uint64_t sequence) {
    const auto taken = images.Take(p_S);
    StereoPair pair;
    pair.left = taken.left;
    pair.right = taken.right;
    pair.sequence = sequence;
    return tracker->Process(pair);
  };
  EXPECT_TRUE(look({0, 0, 0}, 1).found);
  EXPECT_TRUE(tracker->at_rest_known());
  const Eigen::Vector3d way(0.001, -0.0008, 0.0012);
  const SurfaceObservation seen = look(way, 2);
  EXPECT_EQ(seen.sequence, 2U);
  ASSERT_FALSE(seen.points.empty());
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    if (!seen.points[i].seen) continue;
    EXPECT_LT((seen.points[i].p_S - seen.points[i].p_S_rest - way).norm(), 1.5e-4) << i;
    EXPECT_LT((*tracker->Project(seen.points[i].p_S) - tracker->PlaceInImage(i)).norm(), 0.5) << i;
  }
  tracker->Reset();
  EXPECT_FALSE(tracker->at_rest_known());
  for (const SurfacePoint& point : look(way, 3).points) {
    if (!point.seen) continue;
    EXPECT_LT((point.p_S - point.p_S_rest).norm(), 1e-12);
  }
}

// Reference: a plane 100 mm away that moves 2 mm towards the camera.
TEST(SurfacePointTrackerTest, DepthImagesMeasureTheMotionOfTheSurface) {
  Scene scene;
  scene.sense.Set(PointsOptions{TestDepthCamera(), {.track = PointTracking::Track::kSurface}});
  const auto tracker = MakeSurfacePointTracker(scene, {});
  EXPECT_EQ(tracker->stage(), "depth");
  std::mt19937 random(3);
  const auto look = [&](double z) {
    StereoPair pair;
    pair.left = DepthImage(
        *scene.sense.Find<DepthImages>(), [z](double, double) { return z; }, {}, &random);
    return tracker->Process(pair);
  };
  while (!tracker->at_rest_known()) look(0.1);
  const SurfaceObservation seen = look(0.098);
  ASSERT_TRUE(seen.found);
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    ASSERT_TRUE(seen.points[i].seen);
    EXPECT_NEAR(seen.points[i].p_S.z() - seen.points[i].p_S_rest.z(), -0.002, 1e-6) << i;
    EXPECT_LT((*tracker->Project(seen.points[i].p_S) - tracker->PlaceInImage(i)).norm(), 1e-6) << i;
  }
  EXPECT_FALSE(tracker->PlaceInImage(seen.points.size()).allFinite());
  tracker->Reset();
  EXPECT_FALSE(tracker->at_rest_known());
  EXPECT_FALSE(tracker->PlaceInImage(0).allFinite());
}

}  // namespace
}  // namespace palpate
