// References: closed forms of distances between simple shapes.
#include "slave/study/shape/shape_score.h"

#include <gtest/gtest.h>

#include "slave/study/shape/virtual_depth_camera.h"

namespace palpate::study {
namespace {

// An estimate that is moved towards the camera by 12 mm has this error in every distance, and every
// simulated point lies in another leaf than the measured ones, since leaves are 10 mm thick.
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
