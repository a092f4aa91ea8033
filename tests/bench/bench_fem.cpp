// What a step of co-rotational motion costs against the size of the mesh and the tolerance.
//
// Hard foam (E 3800 Pa, nu 0.15, 45 kg/m3), a cube of 6 cm held at x = 0 and pressed at the
// opposite face with up to 0.1 N, ramped over 4 s; implicit Euler, 20 ms, Rayleigh damping 1.0 /s
// and 0.01 s, one linear solve per step, one thread. Times are CPU times of a step; `residual` is
// the largest relative one of the linear systems, in double precision; `error` that of the final
// displacement against a tolerance of 1e-12; `tail` p99 over the median; `solves` the median in
// units of one solution with a factor of Eigen's SimplicialLDLT at hand, `sweeps` in units of
// reading the matrix once.
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <vector>

#include <Eigen/Sparse>
#include <Eigen/SparseCholesky>
#include <benchmark/benchmark.h>

#include "shared/mesh/solid_mesh.h"
#include "slave/mechanics/fem/fem_model.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 0.06, kForce = 0.1, kRamp = 4, kStep = 0.02;
constexpr double kSwing = 1.5, kPeriod = 1;  // of a force that swings sideways [N, s]

double CpuSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The cube of 486 tetrahedra of paper B where it is at hand, else as many in a box.
SolidMesh PaperCube() {
  const std::filesystem::path folder = SourcePath("/../shared/data/seed001_meshes");
  std::ifstream nodes(folder / "cube.node"), tets(folder / "cube.ele");
  if (!nodes || !tets) return MeshBox(Vector3d::Constant(kSide), {3, 3, 9});
  SolidMesh mesh;
  int count = 0, skipped = 0, id = 0;
  nodes >> count >> skipped >> skipped >> skipped;
  for (int i = 0; i < count; ++i) {
    Vector3d p;
    nodes >> id >> p.x() >> p.y() >> p.z();
    mesh.nodes.push_back(p);
  }
  tets >> count >> skipped >> skipped;
  for (int i = 0; i < count; ++i) {
    std::array<int, 4> tet{};
    tets >> id >> tet[0] >> tet[1] >> tet[2] >> tet[3] >> skipped;
    for (int& node : tet) --node;
    mesh.tets.push_back(tet);
  }
  return mesh;
}

SolidMesh MeshOf(int kilo_tets) {
  if (kilo_tets == 0) return PaperCube();
  const std::map<int, std::array<int, 3>> cells{
      {5, {10, 9, 9}}, {20, {15, 15, 15}}, {98, {25, 26, 25}}};
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
  std::vector<std::array<bool, 3>> held;
  int touched = 0;
  const Vector3d centre(kSide, kSide / 2, kSide / 2);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const bool h = mesh.nodes[i].x() < 1e-9;
    held.push_back({h, h, h});
    const auto distance = [&](std::size_t n) { return (mesh.nodes[n] - centre).norm(); };
    if (distance(i) < distance(static_cast<std::size_t>(touched))) touched = static_cast<int>(i);
  }
  FemModel::Params params;
  params.material = {.young_modulus = 3800, .poisson_ratio = 0.15, .density = 45};
  params.options.time = FemOptions::Time::kDynamic;
  params.options.step = kStep;
  params.options.damping_mass = 1.0;
  params.options.damping_stiffness = 0.01;
  params.options.residual = residual;
  FemModel model(mesh, held, params);
  Contact contact{.kind = Contact::Kind::kForce,
                  .p_O = mesh.nodes[static_cast<std::size_t>(touched)],
                  .width = width};
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

// Seconds to read as many bytes as the matrix of the mesh has, nine doubles per block.
double SweepSeconds(const SolidMesh& mesh) {
  std::vector<double> values(mesh.nodes.size() * 15 * 9, 1.0);
  double best = 1, sum = 0;
  for (int repeat = 0; repeat < 20; ++repeat) {
    const double start = CpuSeconds();
    for (std::size_t i = 0; i + 8 <= values.size(); i += 8) {
      for (std::size_t l = 0; l < 8; ++l) values[i + l] *= 1.000001;
    }
    best = std::min(best, CpuSeconds() - start);
    sum += values[static_cast<std::size_t>(repeat)];
  }
  benchmark::DoNotOptimize(sum);
  return best;
}

// A scalar matrix with the mesh's graph takes the place of the elastic one: three solves in one.
double SolveSeconds(const SolidMesh& mesh) {
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& tet : mesh.tets) {
    for (const int i : tet) {
      for (const int j : tet) {
        for (int c = 0; c < 9; ++c) {
          const double value = i == j && c % 4 == 0 ? 12 : -0.1;
          entries.emplace_back(3 * i + c / 3, 3 * j + c % 3, value);
        }
      }
    }
  }
  const auto size = static_cast<Eigen::Index>(3 * mesh.nodes.size());
  Eigen::SparseMatrix<double> K(size, size);
  K.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(K);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(size);
  double best = 1;
  for (int repeat = 0; repeat < 20; ++repeat) {
    const double start = CpuSeconds();
    const Eigen::VectorXd x = factor.solve(b);
    best = std::min(best, CpuSeconds() - start);
    benchmark::DoNotOptimize(x.data());
  }
  return best;
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
    state.counters["sweeps"] = median / SweepSeconds(mesh);
    if (kilo_tets <= 5) state.counters["solves"] = median / SolveSeconds(mesh);
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
  state.counters["most_ms"] = 1e3 * track.seconds.back();
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
