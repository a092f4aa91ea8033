#include "slave/pipeline/points/surface_point_tracker.h"

#include <filesystem>
#include <random>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "slave/vision/dots/dot_layout.h"
#include "tests/slave/pipeline/points/watched_membrane.h"
#include "tests/slave/vision/depth/depth_pictures.h"
#include "tests/slave/vision/dots/dot_pictures.h"
#include "tests/slave/vision/texture/target_pictures.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing_fakes::DotPairs;
using testing_fakes::MembraneScene;
using testing_fakes::PlateDeflection;
using testing_fakes::Press;

// Reference: the plate's closed form, drawn by perspective alone. Tolerance: depth by triangulation
// of one dot is good to z^2 / (f b) sqrt(2) sigma = 1.84 mm / px x 0.03 px.
TEST(TipAndContourTrackerTest, DotsTellHowTheMembraneIsBent) {
  const Scene scene = MembraneScene();
  const auto tracker = MakeSurfacePointTracker(scene, RigOf(scene));
  EXPECT_EQ(tracker->stage(), "dots");
  std::uint64_t sequence = 0;
  while (!tracker->at_rest_known()) {
    ASSERT_LT(sequence, static_cast<std::uint64_t>(tracker->rest_pictures()) + 1);
    StereoPair pair = DotPairs().Draw({}, ++sequence);
    pair.sequence = sequence;
    EXPECT_FALSE(tracker->Process(pair).found);
  }
  EXPECT_EQ(sequence, static_cast<std::uint64_t>(tracker->rest_pictures()));
  const Press press{4.0, {0.008, -0.004}, false};
  StereoPair pair = DotPairs().Draw(press, 77);
  pair.sequence = 78;
  const SurfaceObservation& seen = tracker->Process(pair);
  EXPECT_TRUE(seen.found);
  EXPECT_EQ(seen.sequence, 78U);
  const auto layout = DotPlaces(*scene.sense.Find<PointTracking>());
  ASSERT_EQ(seen.points.size(), layout.size());
  for (std::size_t i = 0; i < layout.size(); ++i) {
    ASSERT_TRUE(seen.points[i].seen) << i;
    const Eigen::Vector3d moved =
        scene.object.X_SO.linear().transpose() * (seen.points[i].p_S - seen.points[i].p_S_rest);
    EXPECT_NEAR(moved.z(), -PlateDeflection(press.force, press.p_O, layout[i]), 1e-4) << i;
    // The place in the picture is that of the place in space.
    const auto p_I = tracker->Project(seen.points[i].p_S);
    ASSERT_TRUE(p_I.has_value());
    EXPECT_LT((*p_I - tracker->PlaceInPicture(i)).norm(), 0.5) << i;
  }
  EXPECT_FALSE(tracker->PlaceInPicture(layout.size()).allFinite());
  EXPECT_NEAR(tracker->radius_px(), 800 * 0.002 / 0.25, 0.2);
}

TEST(TipAndContourTrackerTest, CoveredCamerasSeeNothingAndAResetTakesTheRestAnew) {
  const Scene scene = MembraneScene();
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
  for (int i = 0; i <= tracker->rest_pictures(); ++i) tracker->Process(pressed);
  const SurfaceObservation& seen = tracker->Process(pressed);
  ASSERT_TRUE(seen.found);
  for (const SurfacePoint& point : seen.points) {
    EXPECT_LT((point.p_S - point.p_S_rest).norm(),
              5e-6);  // the same picture, searched near the last places
  }
}

// Reference: the target's own motion, drawn by perspective alone. Tolerance: a window is found to
// 0.03 px, 1.84 mm / px in depth.
TEST(TipAndContourTrackerTest, TextureTellsWhereItsWindowsWent) {
  TargetPictures pictures;
  Scene scene;
  scene.sense.Set(PointsOptions{});
  scene.sense.Find<StereoCameras>()->X_SL = pictures.X_SL;
  scene.sense.Find<PointTracking>()->track = PointTracking::Track::kTexture;
  scene.sense.Find<PointTracking>()->count = 12;
  const auto tracker = MakeSurfacePointTracker(scene, pictures.rig);
  EXPECT_EQ(tracker->stage(), "texture");
  EXPECT_FALSE(tracker->Process(StereoPair{}).found);
  EXPECT_FALSE(tracker->at_rest_known());
  const auto look = [&](const Eigen::Vector3d& p_S, std::uint64_t sequence) {
    const auto taken = pictures.Take(p_S);
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
    EXPECT_LT((*tracker->Project(seen.points[i].p_S) - tracker->PlaceInPicture(i)).norm(), 0.5)
        << i;
  }
  tracker->Reset();
  EXPECT_FALSE(tracker->at_rest_known());
  for (const SurfacePoint& point : look(way, 3).points) {
    if (!point.seen) continue;
    EXPECT_LT((point.p_S - point.p_S_rest).norm(), 1e-12);
  }
}

// Reference: a plane 100 mm away that moves 2 mm towards the camera.
TEST(TipAndContourTrackerTest, DepthTellsWhereTheSurfaceWent) {
  Scene scene;
  scene.sense.Set(PointsOptions{TestDepthCamera(), {.track = PointTracking::Track::kSurface}});
  const auto tracker = MakeSurfacePointTracker(scene, {});
  EXPECT_EQ(tracker->stage(), "depth");
  std::mt19937 random(3);
  const auto look = [&](double z) {
    StereoPair pair;
    pair.left = DepthPicture(
        *scene.sense.Find<DepthPictures>(), [z](double, double) { return z; }, {}, &random);
    return tracker->Process(pair);
  };
  while (!tracker->at_rest_known()) look(0.1);
  const SurfaceObservation seen = look(0.098);
  ASSERT_TRUE(seen.found);
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    ASSERT_TRUE(seen.points[i].seen);
    EXPECT_NEAR(seen.points[i].p_S.z() - seen.points[i].p_S_rest.z(), -0.002, 1e-6) << i;
    EXPECT_LT((*tracker->Project(seen.points[i].p_S) - tracker->PlaceInPicture(i)).norm(), 1e-6)
        << i;
  }
  EXPECT_FALSE(tracker->PlaceInPicture(seen.points.size()).allFinite());
  tracker->Reset();
  EXPECT_FALSE(tracker->at_rest_known());
  EXPECT_FALSE(tracker->PlaceInPicture(0).allFinite());
}

}  // namespace
}  // namespace palpate
