// What a fingertip's contact costs per sample: the place on the finger by each localiser, the place
// on the object's surface, and both. Beside the time: the localiser's median error on presses whose
// normal was measured (0 where the data are absent), the tree's gain over trying every triangle.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <benchmark/benchmark.h>

#include "slave/contact/surface_contact.h"
#include "slave/tactile/localise/fitted_localiser.h"
#include "slave/tactile/localise/localiser.h"
#include "tests/slave/tactile/localise/plate_presses.h"

namespace palpate {
namespace {

constexpr double kRadius = 7e-3;  // of the finger [m]
constexpr double kGate = 0.01;    // [m]

// Measured presses, or falling electrodes in turn where there are none.
struct Signals {
  Signals() {
    const auto measured = presses::Read("trial1", 2440);
    const auto electrodes = presses::Layout();
    is_measured = measured && electrodes;
    layout = is_measured ? *electrodes : SimulatedLayout(kRadius);
    if (is_measured) {
      presses = *measured;
      return;
    }
    for (std::size_t k = 0; k < 400; ++k) {
      TactileSignals change{};
      change[k % kElectrodeCount] = -100;
      change[(k + k / kElectrodeCount) % kElectrodeCount] = -60;
      FingerReading raw;
      raw.electrodes.fill(3000);
      presses.change.push_back(change);
      presses.raw.push_back(raw);
      presses.normal_F.push_back(layout.n_F[k % kElectrodeCount]);
    }
  }
  bool is_measured = false;
  ElectrodeLayout layout;
  presses::Presses presses;
};

const Signals& TheSignals() {
  static const Signals signals;
  return signals;
}

std::unique_ptr<Localiser> Make(const std::string& variant) {
  const Signals& signals = TheSignals();
  if (variant == "fitted") {
    auto weights =
        FitLocaliser(signals.presses.change, signals.presses.normal_F, signals.layout, {});
    return MakeFittedLocaliser(std::move(weights), kRadius);
  }
  Tactile tactile;
  tactile.localise = variant;
  return MakeLocaliser(tactile, signals.layout);
}

void Localise(benchmark::State& state, const std::string& variant) {
  const auto localiser = Make(variant);
  const presses::Presses& presses = TheSignals().presses;
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(localiser->Locate(presses.change[k], presses.raw[k]));
    k = (k + 1) % presses.change.size();
  }
  const bool is_measured = TheSignals().is_measured;
  state.counters["error_deg"] = is_measured ? presses::ErrorsOf(*localiser, presses).median() : 0;
}

// Points within the gate of a 6 cm cube's surface of 12 n^2 triangles.
struct Cube {
  explicit Cube(int n) : surface(SurfaceOf(MeshBox({0.06, 0.06, 0.06}, {n, n, n}))) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(-0.005, 0.065);
    const SurfaceContact contact(surface);
    while (probes.size() < 512) {
      const double x = coordinate(random), y = coordinate(random);
      const Eigen::Vector3d p(x, y, coordinate(random));
      if (contact.Find(p, kGate)) probes.push_back(p);
    }
  }
  SurfaceMesh surface;
  std::vector<Eigen::Vector3d> probes;
};

void FindPlace(benchmark::State& state) {
  const Cube cube(static_cast<int>(state.range(0)));
  const SurfaceContact contact(cube.surface);
  std::size_t k = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(contact.Find(cube.probes[k], kGate));
    k = (k + 1) % cube.probes.size();
  }
  state.counters["triangles"] = static_cast<double>(cube.surface.triangles.size());
}

// The reference: every triangle, one by one.
void TryEveryTriangle(benchmark::State& state) {
  const Cube cube(static_cast<int>(state.range(0)));
  std::size_t k = 0;
  for (auto _ : state) {
    double least = kGate * kGate;
    for (const auto& t : cube.surface.triangles) {
      const auto corner = [&](std::size_t i) {
        return cube.surface.nodes[static_cast<std::size_t>(t[i])];
      };
      const TrianglePlace place =
          ClosestOnTriangle(cube.probes[k], {corner(0), corner(1), corner(2)}, {});
      least = std::min(least, place.distance_squared);
    }
    benchmark::DoNotOptimize(least);
    k = (k + 1) % cube.probes.size();
  }
}

// Electrodes to the nodes of the object, as a pipeline asks for it.
void FingertipToObject(benchmark::State& state) {
  const auto localiser = Make("auto");
  const presses::Presses& presses = TheSignals().presses;
  const SurfaceContact contact(Cube(4).surface);
  const Eigen::Isometry3d X_OF(Eigen::Translation3d(0.03, 0.03, 0.067));
  std::size_t k = 0;
  for (auto _ : state) {
    const TouchPlace touch = localiser->Locate(presses.change[k], presses.raw[k]);
    benchmark::DoNotOptimize(contact.Find(X_OF * touch.p_F, kGate));
    k = (k + 1) % presses.change.size();
  }
}

BENCHMARK_CAPTURE(Localise, paper, std::string("paper"));
BENCHMARK_CAPTURE(Localise, polarity_free, std::string("polarity-free"));
BENCHMARK_CAPTURE(Localise, pressure_weighted, std::string("pressure-weighted"));
BENCHMARK_CAPTURE(Localise, fitted, std::string("fitted"));
BENCHMARK(FindPlace)->Arg(4)->Arg(16)->Arg(64);
BENCHMARK(TryEveryTriangle)->Arg(4)->Arg(16);
BENCHMARK(FingertipToObject);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
