// What the simulated site of two eyes costs beside the pipeline it feeds: a pair of pictures, and a
// press solved ahead. Times are this machine's; the ratio to a plain blur of one picture is the
// figure to watch.
#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>

#include "slave/site/points/stereo_site.h"
#include "tests/slave/site/points/membrane_scenes.h"

namespace palpate {
namespace {

// Reference: one floating-point blur of a 640x480 picture.
void BM_PlainBlur(benchmark::State& state) {
  const cv::Mat picture(480, 640, CV_32F, cv::Scalar(100));
  cv::Mat blurred;
  for (auto _ : state) {
    cv::GaussianBlur(picture, blurred, {7, 7}, 0.7);
    benchmark::DoNotOptimize(blurred.data);
  }
}
BENCHMARK(BM_PlainBlur)->Unit(benchmark::kMillisecond);

void TakePairs(benchmark::State& state, const Scene& scene) {
  StereoSite site(scene, site::kCoarse);
  site.MoveTool(scene.object.X_SO * Eigen::Vector3d(0.01, 0, -scene.operator_options.press_depth));
  for (auto _ : state) benchmark::DoNotOptimize(site.TakePictures().left.data);
}

void BM_PairOfThePressedDots(benchmark::State& state) {
  TakePairs(state, site::MembraneScene());
}
BENCHMARK(BM_PairOfThePressedDots)->Unit(benchmark::kMillisecond);

void BM_PairOfThePressedTexture(benchmark::State& state) {
  Scene scene = site::MembraneScene();
  scene.sense.Find<PointTracking>()->track = PointTracking::Track::kTexture;
  TakePairs(state, scene);
}
BENCHMARK(BM_PairOfThePressedTexture)->Unit(benchmark::kMillisecond);

void BM_PairOfTheTarget(benchmark::State& state) {
  TakePairs(state, site::TargetScene());
}
BENCHMARK(BM_PairOfTheTarget)->Unit(benchmark::kMillisecond);

// To 5 mm, 13 rungs, on the site's own mesh.
void SolvePress(benchmark::State& state, double radius) {
  const Scene scene = site::MembraneScene();
  double force = 0;
  for (auto _ : state) {
    site::PressedMembrane membrane(std::get<MembraneGeometry>(scene.object.geometry),
                                   scene.object.material, scene.tool->width, {radius, 0});
    for (const double depth : {0.1, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 4.5, 5.0}) {
      if (!membrane.Deepen(1e-3 * depth)) state.SkipWithError("no equilibrium");
    }
    force = -membrane.press().rungs.back()->force;
  }
  state.counters["force_N"] = force;
}
void BM_PressAtTheCentre(benchmark::State& state) {
  SolvePress(state, 0);
}
void BM_PressBesideIt(benchmark::State& state) {
  SolvePress(state, 0.0117);
}
BENCHMARK(BM_PressAtTheCentre)->Unit(benchmark::kMillisecond)->Iterations(1);
BENCHMARK(BM_PressBesideIt)->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
