// What the simulated site with fingertips costs beside the loops it feeds: a sample, a step of the
// hand, and a press solved ahead. Times are this machine's; the ratio to a plain sum of as many
// exponentials as a sample's skin has points is the figure to watch.
#include <cmath>

#include <benchmark/benchmark.h>

#include "slave/site/fingertips/simulated_fingertip.h"
#include "slave/site/fingertips/tactile_site.h"
#include "tests/slave/site/fingertips/touch_scenes.h"

namespace palpate {
namespace {

void BM_PlainExponentials(benchmark::State& state) {
  double x = 0.1;
  for (auto _ : state) {
    double sum = 0;
    for (std::size_t i = 0; i < site::SkinSurface::kCount; ++i) {
      sum += std::exp(x * static_cast<double>(i));
    }
    benchmark::DoNotOptimize(sum);
    x = -x;
  }
}
BENCHMARK(BM_PlainExponentials);

void BM_FingertipSample(benchmark::State& state) {
  SimulatedFingertip fingertip(1);
  const FingertipLoad load{{0, 0, -site::kSkinRadius}, {0.1, 0, 1}, 4e-3};
  for (auto _ : state) benchmark::DoNotOptimize(fingertip.Sample(&load, 0.01));
}
BENCHMARK(BM_FingertipSample);

void BM_SampleOfTwoPinchingFingers(benchmark::State& state) {
  TactileSite site(site::PinchScene());
  site.MoveTool(site.home() + (site.gap() + 1e-3) * site.approach());
  for (auto _ : state) benchmark::DoNotOptimize(site.TakeSample(Time{}));
}
BENCHMARK(BM_SampleOfTwoPinchingFingers);

void BM_MoveHandInContact(benchmark::State& state) {
  TactileSite site(site::PinchScene());
  double depth = 1e-3;
  for (auto _ : state) {
    site.MoveTool(site.home() + (site.gap() + depth) * site.approach());
    depth = depth > 1e-3 ? 0.9e-3 : 1.1e-3;
  }
}
BENCHMARK(BM_MoveHandInContact);

// From nothing to a press of 3 mm into the foam cube, waited for.
void BM_PressOfTheCubeSolvedAhead(benchmark::State& state) {
  for (auto _ : state) {
    TactileSite site(site::CubeScene());
    site.MoveTool(site.home() + (site.gap() + 3e-3) * site.approach());
    state.counters["newton"] = site.truth().force.z();
  }
}
BENCHMARK(BM_PressOfTheCubeSolvedAhead)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
