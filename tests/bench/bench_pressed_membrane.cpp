// What the truth of a pressed membrane costs: a new place, and a whole press of 0 to 5 mm in half
// millimetres, with its error against a mesh of half as many elements more along the plate. Times
// are this machine's; the ratio to a plain product of dense matrices is the figure to watch.
#include <cmath>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "slave/site/points/membrane/pressed_membrane.h"

namespace palpate::site {
namespace {

constexpr double kRadius = 0.039, kDeepest = 5e-3;

PressedMembrane Rubber(double place, const MembraneResolution& resolution) {
  return {{kRadius, 1e-3}, {27.2e6, 0.45}, 0.004, {place * kRadius, 0}, resolution};
}

double ForceOfLadder(PressedMembrane* membrane) {
  for (int k = 1; k <= 10; ++k) {
    if (!membrane->Deepen(kDeepest * k / 10)) return std::nan("");
  }
  return membrane->press().rungs.back()->force;
}

void BM_PlainProduct(benchmark::State& state) {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Random(500, 500);
  Eigen::MatrixXd b = a;
  for (auto _ : state) {
    b.noalias() = a * a.transpose();
    benchmark::DoNotOptimize(b.data());
  }
}
BENCHMARK(BM_PlainProduct)->Unit(benchmark::kMillisecond);

// Places in hundredths of the radius.
void BM_NewPlace(benchmark::State& state) {
  for (auto _ : state) {
    const auto membrane = Rubber(0.01 * static_cast<double>(state.range(0)), {});
    benchmark::DoNotOptimize(&membrane);
  }
}
BENCHMARK(BM_NewPlace)->Arg(0)->Arg(50)->Unit(benchmark::kMillisecond);

// Places as above, elements from the centre to the rim.
void BM_Press(benchmark::State& state) {
  const double place = 0.01 * static_cast<double>(state.range(0));
  const int across = static_cast<int>(state.range(1));
  double force = 0;
  for (auto _ : state) {
    auto membrane = Rubber(place, {across, 1});
    force = ForceOfLadder(&membrane);
  }
  auto fine = Rubber(place, {across * 3 / 2, 1});
  state.counters["force_error"] = std::abs(force / ForceOfLadder(&fine) - 1);
}
BENCHMARK(BM_Press)->ArgsProduct({{0, 50, 70}, {6, 8, 10}})->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate::site

BENCHMARK_MAIN();
