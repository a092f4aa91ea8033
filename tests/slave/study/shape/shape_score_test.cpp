// References: closed forms of distances between simple shapes.
#include "slave/study/shape/shape_score.h"

#include <cmath>

#include <gtest/gtest.h>

#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {
namespace {

using Eigen::Vector3d;

TEST(ShapeScoreTest, DistancesToABoxAreThoseToItsFacesEdgesAndCorners) {
  const SurfaceMesh box = SurfaceOf(MeshBox({0.1, 0.1, 0.1}, {3, 3, 3}));
  const std::vector<Vector3d> points{{0.05, 0.05, 0.13},   // before a face
                                     {0.05, 0.05, 0.08},   // inside
                                     {0.13, 0.14, 0.05},   // beside an edge
                                     {0.12, 0.12, 0.11}};  // off a corner
  const auto d = DistancesToSurface(points, box);
  ASSERT_EQ(d.size(), 4U);
  EXPECT_NEAR(d[0], 0.03, 1e-12);
  EXPECT_NEAR(d[1], 0.02, 1e-12);
  EXPECT_NEAR(d[2], 0.05, 1e-12);
  EXPECT_NEAR(d[3], 0.03, 1e-12);
}

TEST(ShapeScoreTest, DistancesToACloudAreThoseToItsNearestPoint) {
  const std::vector<Vector3d> cloud{{0, 0, 0}, {1, 0, 0}};
  const std::vector<Vector3d> points{{0.4, 0.3, 0}, {0.9, 0, 0}};
  const auto d = DistancesToCloud(points, cloud);
  ASSERT_EQ(d.size(), 2U);
  EXPECT_NEAR(d[0], 0.5, 1e-7);  // single precision
  EXPECT_NEAR(d[1], 0.1, 1e-7);
}

// An estimate moved towards the camera by 12 mm is off by that in every distance, and every
// simulated point lies in another leaf than the measured ones: their layers are 10 mm thick.
TEST(ShapeScoreTest, ShapeThatIsRightScoresOneAndOneThatIsOffScoresNothing) {
  DepthCamera camera;
  camera.noise = 0;
  SurfaceMesh square{
      {{-0.1, -0.1, 0.805}, {0.1, -0.1, 0.805}, {0.1, 0.1, 0.805}, {-0.1, 0.1, 0.805}},
      {{0, 2, 1}, {0, 3, 2}}};
  const auto measured = ScanSurface(camera, square, {}, 1);
  const ShapeScore right = Score(measured, ScanSurface(camera, square, {}, 2), square, 0.01);
  EXPECT_EQ(right.octree, 1);
  EXPECT_NEAR(right.measured_to_surface.max, 0, 1e-12);
  EXPECT_NEAR(right.simulated_to_measured.max, 0, 1e-7);
  for (auto& p : square.nodes) p.z() -= 0.012;
  const auto simulated = ScanSurface(camera, square, {}, 2);
  const ShapeScore wrong = Score(measured, simulated, square, 0.01);
  EXPECT_EQ(wrong.octree, 0);
  EXPECT_EQ(wrong.measured, measured.size());
  EXPECT_EQ(wrong.simulated, simulated.size());
  EXPECT_NEAR(wrong.measured_to_surface.rms, 0.012, 1e-12);
  EXPECT_NEAR(wrong.simulated_to_measured.mean, 0.012, 1e-4);  // the rays slant a little
}

}  // namespace
}  // namespace palpate::study
