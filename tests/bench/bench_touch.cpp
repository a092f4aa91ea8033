// The whole way from tactile samples to forces and the object's shape: windows of the network,
// contact points, places on the mesh, co-rotational equilibrium; five fingertips on a foam cube of
// about the size of paper B's mesh (150 nodes, 480 tetrahedra; the paper's has 153 and 486). One
// thread, CPU time. Paper B: 185 Hz per sensor model, 50 Hz deformation, 20 Hz together.
#include <cmath>
#include <numbers>

#include <benchmark/benchmark.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "tests/slave/tactile/network/reference_network.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr int kRest = 50;

Finger At(double x, double y, double z, const Vector3d& axis, double angle) {
  Finger finger;
  finger.X_SF = Eigen::Translation3d(x, y, z) * Eigen::AngleAxisd(angle, axis);
  finger.has_pose = true;
  return finger;
}

// The pads 1 mm deep in the top (three) and two sides.
Scene FiveOnCube() {
  constexpr double kQuarter = std::numbers::pi / 2;
  Scene scene;
  scene.name = "five";
  scene.object.geometry = BoxGeometry{{0.06, 0.06, 0.06}, {4, 4, 5}};
  scene.object.material = {3800, 0.15, 45, 0};
  scene.object.fixed = {{FixedPlane{2, 0}}};
  scene.model.kind = "fem";
  Tactile tactile;
  tactile.source = Tactile::Source::kStream;
  const Vector3d x = Vector3d::UnitX(), y = Vector3d::UnitY();
  tactile.fingers = {At(0.03, 0.03, 0.066, x, 0), At(0.015, 0.02, 0.066, x, 0),
                     At(0.05, 0.045, 0.066, x, 0), At(0.066, 0.03, 0.035, y, kQuarter),
                     At(-0.006, 0.03, 0.035, y, -kQuarter)};
  scene.manipulator.home = tactile.fingers[0].X_SF * Vector3d(0, 0, -tactile.finger_radius);
  scene.sense.Set(tactile);
  return scene;
}

// Small forces, as they come from a network with random weights.
TactileSenses Senses(const Scene& scene) {
  RandomNetwork random = MakeRandomNetwork("rnn_21", 20, 0.3F, 1);
  random.info.gain = 0.05;
  return {MakeForceNetwork(random.info, random.weights),
          MakeLocaliser(*scene.sense.Find<Tactile>(),
                        SimulatedLayout(scene.sense.Find<Tactile>()->finger_radius))};
}

// Counts that wander; the front of the pad more than the rest, so that places wander too.
TactileFrame FrameAt(std::uint64_t sample) {
  static const std::vector<TactileSignals> signals = RandomSignals(1024, 60, 2);
  TactileFrame frame;
  frame.sequence = sample + 1;
  for (std::size_t f = 0; f < kMaxFingers; ++f) {
    FingerReading& reading = frame.fingers[f];
    reading.present = true;
    const TactileSignals& change = signals[(sample + 200 * f) % signals.size()];
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      reading.electrodes[i] = static_cast<float>(3000 + (sample < kRest ? 0 : change[i]));
    }
    reading.pac = 2000;
    reading.pdc = 2200 + (sample < kRest ? 0.0F : 40.0F);
  }
  return frame;
}

// kHz: frames of five fingertips per second; us_*: medians of the stages; `touching`: how many
// fingertips acted on the mesh on average.
void FiveFingertips(benchmark::State& state) {
  const Scene scene = FiveOnCube();
  TactileEstimator estimator(scene, Senses(scene));
  std::uint64_t sample = 0;
  double acting = 0;
  for (; sample < 200; ++sample) estimator.Estimate(FrameAt(sample), scene.manipulator.home);
  for (auto _ : state) {
    state.PauseTiming();
    const TactileFrame frame = FrameAt(sample++);
    state.ResumeTiming();
    estimator.Estimate(frame, scene.manipulator.home);
    acting += static_cast<double>(estimator.object().contacts().size());
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["touching"] = acting / static_cast<double>(state.iterations());
  state.counters["us_tactile"] = estimator.times().tactile.Quantile(0.5);
  state.counters["us_contact"] = estimator.times().contact.Quantile(0.5);
  state.counters["us_mechanics"] = estimator.times().mechanics.Quantile(0.5);
  state.counters["us_total"] = estimator.times().total.Quantile(0.5);
}
BENCHMARK(FiveFingertips)->Unit(benchmark::kMicrosecond);

// The deformation alone: one fingertip whose force changes from sample to sample.
void DeformationOfTheCube(benchmark::State& state) {
  const Scene scene = FiveOnCube();
  const auto model = MakeModel(scene, MeshObject(scene, std::nullopt));
  Contact contact{.kind = Contact::Kind::kForce, .p_O = {0.03, 0.031, 0.06}};
  ContactResponse response;
  int i = 0;
  for (auto _ : state) {
    contact.prescribed_O.z() = -0.1 - 0.002 * std::sin(0.1 * ++i);
    model->Respond({&contact, 1}, {&response, 1});
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["dof"] = static_cast<double>(model->info().dof);
}
BENCHMARK(DeformationOfTheCube)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
