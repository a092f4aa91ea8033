// What the simulated site costs beside the loops it feeds: a picture, and a contact place solved
// ahead. Times are this machine's; the ratio to a plain blur of the same picture is the figure to
// watch.
#include <benchmark/benchmark.h>
#include <opencv2/imgproc.hpp>

#include "slave/site/camera/patch_solution.h"
#include "slave/site/camera/simulated_site.h"
#include "tests/slave/site/camera/site_scenes.h"

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

void BM_PictureOfThePressedBlock(benchmark::State& state) {
  SimulatedSite site(site::BlockScene());
  site.MoveTool({0.044, 0.089, 0});
  double y = 0.083;
  for (auto _ : state) {
    site.MoveTool({0.044, y += 1e-7, 0});
    benchmark::DoNotOptimize(site.TakePicture().data);
  }
}
BENCHMARK(BM_PictureOfThePressedBlock)->Unit(benchmark::kMillisecond)->Iterations(500);

void BM_PictureOfThePressedEmbryo(benchmark::State& state) {
  SimulatedSite site(site::EmbryoScene());
  site.MoveTool({0.61e-3, 0, 0});
  double x = 0.5e-3;
  for (auto _ : state) {
    site.MoveTool({x += 1e-8, 0, 0});
    benchmark::DoNotOptimize(site.TakePicture().data);
  }
}
BENCHMARK(BM_PictureOfThePressedEmbryo)->Unit(benchmark::kMillisecond)->Iterations(500);

void BM_PictureBeforeTheTouch(benchmark::State& state) {
  SimulatedSite site(site::BlockScene());
  double y = 0.091;
  for (auto _ : state) {
    site.MoveTool({0.044, y += 1e-7, 0});
    benchmark::DoNotOptimize(site.TakePicture().data);
  }
}
BENCHMARK(BM_PictureBeforeTheTouch)->Unit(benchmark::kMillisecond)->Iterations(500);

void BM_MoveTool(benchmark::State& state) {
  SimulatedSite site(site::BlockScene());
  double y = 0.091;
  for (auto _ : state) site.MoveTool({0.044, y += 1e-9, 0});
}
BENCHMARK(BM_MoveTool)->Unit(benchmark::kMicrosecond);

void SolvePlace(benchmark::State& state, const Scene& scene, const Eigen::Vector2d& near) {
  const site::TrueBody body(scene);
  double nodes = 0;
  for (auto _ : state) {
    const auto solution = SolvePatch(body, scene.object.material.poisson_ratio, scene.model.plane,
                                     body.Nearest(near), scene.tool->width);
    nodes = static_cast<double>(solution.mesh.nodes.size());
  }
  state.counters["unknowns"] = 2 * nodes;
}
void BM_SolveBlockPlaneStress(benchmark::State& state) {
  SolvePlace(state, site::BlockScene(), {0.044, 0.088});
}
void BM_SolveEmbryoIncompressible(benchmark::State& state) {
  SolvePlace(state, site::EmbryoScene(), {0.6e-3, 0});
}
BENCHMARK(BM_SolveBlockPlaneStress)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_SolveEmbryoIncompressible)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
