// Time of a step of co-rotational dynamics by mesh size and tolerance.
//
// Hard foam (E 3800 Pa, nu 0.15, 45 kg/m3), a cube of 6 cm held at x = 0 and pressed at the
// opposite face with up to 0.1 N, ramped over 4 s; implicit Euler, 20 ms, one linear solve per
// step, one thread. Times are CPU times of a step; `residual` is the largest relative one of the
// linear systems, in double precision; `error` that of the final displacement against a tolerance
// of 1e-12; `tail` p99 over the median.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <vector>

#include <benchmark/benchmark.h>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/fem_model.h"
#include "tests/bench/timing.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 0.06, kForce = 0.1, kRamp = 4, kStep = 0.02;
constexpr double kSwing = 1.5, kPeriod = 1;  // of a force that swings sideways [N, s]

SolidMesh MeshOf(int kilo_tets) {
  const std::map<int, std::array<int, 3>> cells{
      {0, {3, 3, 9}}, {5, {10, 9, 9}}, {20, {15, 15, 15}}, {98, {25, 26, 25}}};
  return MeshBox(Vector3d::Constant(kSide), cells.at(kilo_tets));
}

struct Track {
  std::vector<double> seconds;  // per step, sorted
  double residual = 0;          // largest
  double iterations = 0;        // mean
  Vector3d displacement{0, 0, 0};
  double dof = 0;
};

Track Press(const SolidMesh& mesh, double width, double residual, int steps, bool swings = false) {
  const HeldNodes held = FixedWhere(mesh, [](const Vector3d& p) { return p.x() < 1e-9; });
  const Vector3d centre(kSide, kSide / 2, kSide / 2);
  const Vector3d touched = *std::ranges::min_element(
      mesh.nodes, {}, [&](const Vector3d& p) { return (p - centre).norm(); });
  FemModel::Params params;
  params.material = {.young_modulus = 3800, .poisson_ratio = 0.15, .density = 45};
  params.options.time = FemOptions::Time::kDynamic;
  params.options.step = kStep;
  params.options.residual = residual;
  FemModel model(mesh, held, params);
  Contact contact{.kind = Contact::Kind::kForce, .p_O = touched, .width = width};
  ContactResponse response;
  Track track;
  track.dof = static_cast<double>(model.info().dof);
  for (int step = 1; step <= steps; ++step) {
    contact.prescribed_O = {-kForce * std::min(1.0, step * kStep / kRamp), 0, 0};
    if (swings) contact.prescribed_O = {0, 0, kSwing * std::sin(2 * M_PI * step * kStep / kPeriod)};
    const double start = CpuSeconds();
    model.Respond({&contact, 1}, {&response, 1});
    track.seconds.push_back(CpuSeconds() - start);
    track.residual = std::max(track.residual, model.residual());
    track.iterations += static_cast<double>(model.stepper()->last_solve().iterations) / steps;
  }
  std::sort(track.seconds.begin(), track.seconds.end());
  track.displacement = response.displacement_O;
  return track;
}

void ImplicitStep(benchmark::State& state) {
  const int kilo_tets = static_cast<int>(state.range(0));
  const double residual = std::pow(10.0, -static_cast<double>(state.range(1)));
  const double width = 1e-3 * static_cast<double>(state.range(2));
  const SolidMesh mesh = MeshOf(kilo_tets);
  const int steps = kilo_tets > 20 ? 40 : 200;
  Track track;
  for (auto _ : state) {
    track = Press(mesh, width, residual, steps);
    const double median = track.seconds[track.seconds.size() / 2];
    state.SetIterationTime(median);
    state.counters["median_ms"] = 1e3 * median;
  }
  const auto p99 = static_cast<std::size_t>(0.99 * static_cast<double>(track.seconds.size()));
  state.counters["p99_ms"] = 1e3 * track.seconds[p99];
  state.counters["tail"] = track.seconds[p99] / track.seconds[track.seconds.size() / 2];
  state.counters["dof"] = track.dof;
  state.counters["residual"] = track.residual;
  state.counters["iterations"] = track.iterations;
  if (kilo_tets <= 20) {
    const Vector3d exact = Press(mesh, width, 1e-12, steps).displacement;
    state.counters["error"] = (track.displacement - exact).norm() / exact.norm();
  }
}

// The tail of a large motion, in which tangents change and factors age.
void SwingingStep(benchmark::State& state) {
  const int kilo_tets = static_cast<int>(state.range(0));
  const double residual = std::pow(10.0, -static_cast<double>(state.range(1)));
  Track track;
  for (auto _ : state) {
    track = Press(MeshOf(kilo_tets), 0.02, residual, 400, true);
    state.SetIterationTime(track.seconds[200]);
  }
  state.counters["median_ms"] = 1e3 * track.seconds[200];
  state.counters["p99_ms"] = 1e3 * track.seconds[396];
  state.counters["max_ms"] = 1e3 * track.seconds.back();
  state.counters["tail"] = track.seconds[396] / track.seconds[200];
  state.counters["iterations"] = track.iterations;
}
BENCHMARK(SwingingStep)
    ->ArgNames({"ktets", "digits"})
    ->ArgsProduct({{5, 20}, {3, 6}})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(ImplicitStep)
    ->ArgNames({"ktets", "digits", "width_mm"})
    ->ArgsProduct({{0, 5, 20, 98}, {3, 6, 9}, {20}})
    ->Args({0, 6, 0})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
