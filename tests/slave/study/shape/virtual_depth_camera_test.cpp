// References: where rays meet planes, boxes, spheres and capsules, in closed form; the law of large
// numbers for the noise.
#include "slave/study/shape/virtual_depth_camera.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace palpate::study {
namespace {

using Eigen::Vector3d;

// Looks along S's z from its origin, x right, y down.
DepthCamera VirtualCamera(double noise = 0) {
  DepthCamera camera;
  camera.size = {160, 120};
  camera.focal = 130;
  camera.noise = noise;
  return camera;
}

SurfaceMesh Square(double half, double z) {
  return {{{-half, -half, z}, {half, -half, z}, {half, half, z}, {-half, half, z}},
          {{0, 2, 1}, {0, 3, 2}}};
}

// Distance of `p` to the ray through the nearest pixel's centre, in pixels.
double PixelError(const DepthCamera& camera, const Vector3d& p) {
  double worst = 0;
  for (int axis = 0; axis < 2; ++axis) {
    const double at =
        camera.focal * p[axis] / p.z() + 0.5 * camera.size[static_cast<std::size_t>(axis)] - 0.5;
    worst = std::max(worst, std::abs(at - std::round(at)));
  }
  return worst;
}

TEST(VirtualDepthCameraTest, PlaneIsHitOncePerPixelOnTheRayThroughItsCentre) {
  const DepthCamera camera = VirtualCamera();
  const auto cloud = ScanSurface(camera, Square(10, 0.8), {}, 1);
  ASSERT_EQ(cloud.size(), 160U * 120U);  // every ray, also those along the shared edge
  for (const auto& p : cloud) {
    ASSERT_NEAR(p.z(), 0.8, 1e-12);  // a division and a product of numbers near one
    ASSERT_LT(PixelError(camera, p), 1e-9);
  }
}

TEST(VirtualDepthCameraTest, CapsuleHidesTheConeBehindItAndIsNotSeenItself) {
  const SurfaceMesh plane = Square(10, 0.8);
  const Occluder finger{{-0.03, 0, 0.4}, {0.05, 0.02, 0.45}, 0.01};
  const auto open = ScanSurface(VirtualCamera(), plane, {}, 1);
  const auto cloud = ScanSurface(VirtualCamera(), plane, {&finger, 1}, 1);
  // Reference: the distance between a ray and the axis as two segments, by fine sampling.
  const auto hidden = [&](const Vector3d& p) {
    double nearest = 1;
    constexpr int kSteps = 4000;
    for (int i = 0; i <= kSteps; ++i) {
      const Vector3d q = finger.a + (finger.b - finger.a) * i / kSteps;
      nearest = std::min(nearest, q.cross(p).norm() / p.norm());
    }
    return nearest < finger.radius;
  };
  const auto expected = std::ranges::count_if(open, [&](const auto& p) { return !hidden(p); });
  EXPECT_LT(cloud.size(), open.size());
  // Sampling changes the radius by at most 1e-7 m, which cannot change a pixel of 3 mm.
  EXPECT_EQ(static_cast<std::ptrdiff_t>(cloud.size()), expected);
  for (const auto& p : cloud) EXPECT_NEAR(p.z(), 0.8, 1e-12);
}

TEST(VirtualDepthCameraTest, NoiseIsGaussianAlongTheRayAndDependsOnTheSeedAlone) {
  const double sigma = 0.003;
  const auto exact = ScanSurface(VirtualCamera(), Square(10, 0.8), {}, 1);
  const auto noisy = ScanSurface(VirtualCamera(sigma), Square(10, 0.8), {}, 7);
  ASSERT_EQ(exact.size(), noisy.size());
  EXPECT_EQ(noisy, ScanSurface(VirtualCamera(sigma), Square(10, 0.8), {}, 7));
  EXPECT_NE(noisy, ScanSurface(VirtualCamera(sigma), Square(10, 0.8), {}, 8));
  double sum = 0, squares = 0, within = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const Vector3d off = noisy[i] - exact[i];
    const double along = off.dot(exact[i].normalized());
    ASSERT_NEAR(off.norm(), std::abs(along), 1e-12);
    sum += along;
    squares += along * along;
    within += std::abs(along) < sigma ? 1 : 0;
  }
  const auto n = static_cast<double>(exact.size());  // 19200: four standard errors below
  EXPECT_NEAR(sum / n, 0, 4 * sigma / std::sqrt(n));
  EXPECT_NEAR(std::sqrt(squares / n), sigma, 4 * sigma / std::sqrt(2 * n));
  EXPECT_NEAR(within / n, 0.6827, 4 * std::sqrt(0.6827 * 0.3173 / n));
}

TEST(VirtualDepthCameraTest, TriangleThatReachesBehindTheCameraIsCutNotMirrored) {
  // A floor 0.2 m below the camera (y is down) from 1 m behind it to 3 m before it.
  const SurfaceMesh floor{{{-50, 0.2, -1}, {50, 0.2, -1}, {0, 0.2, 3}}, {{0, 1, 2}}};
  const auto cloud = ScanSurface(VirtualCamera(), floor, {}, 1);
  ASSERT_GT(cloud.size(), 1000U);
  for (const auto& p : cloud) {
    EXPECT_NEAR(p.y(), 0.2, 1e-12);
    EXPECT_GT(p.z(), 0);
  }
}

}  // namespace
}  // namespace palpate::study
