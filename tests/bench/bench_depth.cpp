// Depth pictures to points, and points to the force on a membrane; one thread. A 640 x 480 picture
// of a dome is copied beside it: what any work on the picture costs at least.
#include <cmath>
#include <random>

#include <benchmark/benchmark.h>

#include "slave/mechanics/membrane/inflated_membrane.h"
#include "slave/pipeline/press/membrane_press.h"
#include "slave/vision/depth/depth_points.h"
#include "tests/slave/vision/depth/depth_pictures.h"

namespace palpate {
namespace {

constexpr double kRadius = 0.05;
const Eigen::Vector3d kCentre(0, 0, 0.05);

DepthPoints::Params Camera(int cell) {
  DepthPoints::Params params;
  params.camera.unit = 1e-4;
  params.camera.fx = params.camera.fy = 434;
  params.camera.cx = 319.5;
  params.camera.cy = 239.5;
  params.camera.sigma = 0.08e-3;
  params.cell = cell;
  params.rest_pictures = 5;
  return params;
}

// The far side of a sphere, dented where the camera looks by `depth` [m].
cv::Mat Dome(double depth, std::mt19937* random) {
  return DepthPicture(
      Camera(16).camera,
      [depth](double x, double y) {
        const Eigen::Vector3d ray(x, y, 1);
        const double b = ray.dot(kCentre);
        const double root = b * b - ray.squaredNorm() * (kCentre.squaredNorm() - kRadius * kRadius);
        const double z = (b + std::sqrt(root)) / ray.squaredNorm();
        const double r2 = (x * x + y * y) / (0.1 * 0.1);
        return z - depth * std::exp(-r2);
      },
      {0.08e-3, 8}, random, 640, 480);
}

struct Pictures {
  std::vector<cv::Mat> rest, pressed;
  Pictures() {
    std::mt19937 random(1);
    for (int k = 0; k < 5; ++k) rest.push_back(Dome(0, &random));
    for (int k = 0; k < 4; ++k) pressed.push_back(Dome(2e-3, &random));
  }
};
const Pictures& Shown() {
  static const Pictures pictures;
  return pictures;
}

void BM_CopyPicture(benchmark::State& state) {
  cv::Mat copy = Shown().pressed[0].clone();
  std::size_t k = 0;
  for (auto _ : state) {
    Shown().pressed[k++ % 4].copyTo(copy);
    benchmark::DoNotOptimize(copy.data);
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_CopyPicture)->Unit(benchmark::kMicrosecond);

void BM_DepthPoints(benchmark::State& state) {
  DepthPoints eyes(Camera(static_cast<int>(state.range(0))));
  for (const auto& picture : Shown().rest) eyes.Observe(picture, 1, {});
  std::size_t k = 0;
  const SurfaceObservation* seen = nullptr;
  for (auto _ : state) seen = &eyes.Observe(Shown().pressed[k++ % 4], 2, {});
  // Beside the time: how far the points' ways scatter where nothing moved.
  double squares = 0;
  int count = 0;
  for (const SurfacePoint& point : seen->points) {
    if (point.p_S_rest.head<2>().norm() < 0.03 || !point.seen) continue;
    squares += (point.p_S - point.p_S_rest).squaredNorm();
    ++count;
  }
  state.counters["points"] = static_cast<double>(seen->points.size());
  state.counters["scatter_um"] = 1e6 * std::sqrt(squares / count);
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_DepthPoints)->Arg(8)->Arg(16)->Arg(32)->Unit(benchmark::kMicrosecond);

void BM_DepthToForce(benchmark::State& state) {
  DepthPoints eyes(Camera(16));
  for (const auto& picture : Shown().rest) eyes.Observe(picture, 1, {});
  Ellipsoid sphere;
  sphere.centre = kCentre;
  sphere.semi_axes *= kRadius;
  const auto rings = static_cast<int>(state.range(0));
  MembranePress press(InflatedMembrane(MeshDomedMembrane(sphere, {0, 0, 1}, 0.055, rings),
                                       {.modulus = 1200, .tension = 300}),
                      {});
  press.Fit(eyes.Observe(Shown().pressed[0], 2, {}).points);
  std::size_t k = 0;
  for (auto _ : state) {
    const auto& seen = eyes.Observe(Shown().pressed[k++ % 4], 2, {});
    benchmark::DoNotOptimize(&press.Fit(seen.points));
  }
  state.counters["nodes"] = static_cast<double>(press.membrane().surface().nodes.size());
  state.counters["points"] = press.reading().points;
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(BM_DepthToForce)->Arg(12)->Arg(16)->Arg(20)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
