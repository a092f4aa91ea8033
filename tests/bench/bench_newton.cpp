// The full solution of a neo-Hookean body: time of one answer from rest, and the answer itself, so
// that compare.py finds two builds' times and differences in one run.
//
// A cube held at the bottom and touched on top: `move`, a disc moved down and aside; `load`, the
// same disc loaded. `tet10`: 12.7k unknowns; `tet4`: 101,400 tetrahedra, 57k unknowns. One thread,
// CPU time, mean of three places. Counters: `same_*` are parts of the answers, relative to the
// largest displacement or force; `steps` of Newton's method; `ratio`, the time over that of a
// dense product of 768 x 768 matrices.
#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "tests/bench/timing.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using Element = FemOptions::Element;

constexpr double kSide = 0.06;        // [m]
constexpr double kModulus = 10e3;     // [Pa]
constexpr double kDepth = 0.008;      // [m]
constexpr double kWidth = 0.016;      // of the disc [m]
constexpr double kProbeTurns = 1.37;  // of the waves that sample the displacements, per node

void FullSolution(benchmark::State& state, Element element, Contact::Kind kind, double nu) {
  const bool quadratic = element == Element::kTet10;
  const SolidMesh mesh = quadratic ? MeshBox({kSide / 2, kSide / 2, kSide}, {6, 6, 12})
                                   : MeshBox(Vector3d::Constant(kSide), {26, 25, 26});
  const Vector3d size = mesh.nodes.back();
  const HeldNodes held = FixedWhere(mesh, [](const Vector3d& p) { return p.z() == 0; });
  SolidModel::Params params;
  params.options.element = element;
  params.options.law = FemOptions::Law::kNeoHookean;
  params.young_modulus = kModulus;
  params.poisson_ratio = nu;
  SolidModel model(mesh, held, params);

  const double reference = ProductSeconds();
  double spent = 0, steps = 0;
  int answers = 0;
  for (auto _ : state) {
    for (const auto& [x, y] : {std::pair{0.5, 0.5}, {0.4, 0.6}, {0.62, 0.45}}) {
      Contact contact{.kind = kind, .p_O = {x * size.x(), y * size.y(), size.z()}};
      contact.width = kWidth;
      contact.prescribed_O = Vector3d(0.3, 0.1, -1) * kDepth;
      if (kind == Contact::Kind::kForce) contact.prescribed_O *= 0.4 * kModulus * kWidth;
      ContactResponse response;
      model.Reset();
      const double start = CpuSeconds();
      model.Respond({&contact, 1}, {&response, 1});
      spent += CpuSeconds() - start;
      if (response.validity == Validity::kFailed) {
        state.SkipWithError(std::string(model.failure()).c_str());
        return;
      }
      steps += model.newton_steps();
      double largest = 0, wave = 0;
      for (int node = 0; node < model.mesh().node_count(); ++node) {
        largest = std::max(largest, model.displacement(node).norm());
        const double turn = kProbeTurns * node;
        wave += model.displacement(node).dot(
            Vector3d(std::cos(turn), std::sin(2 * turn), std::cos(3 * turn + 1)));
      }
      const std::string place = "same_" + std::to_string(answers++ % 3);
      const double nodes = std::sqrt(static_cast<double>(model.mesh().node_count()));
      state.counters[place + "_wave"] = wave / (largest * nodes);
      state.counters[place + "_depth"] = response.displacement_O.z() / largest;
      state.counters[place + "_force"] = response.force_O.norm() / (kModulus * kWidth * kDepth);
    }
  }
  state.counters["dof"] = static_cast<double>(model.info().dof);
  state.counters["steps"] = steps / answers;
  state.counters["ratio"] = spent / answers / reference;
  state.SetIterationTime(spent / answers);
}

#define PALPATE_FULL_SOLUTION(name, ...)             \
  BENCHMARK_CAPTURE(FullSolution, name, __VA_ARGS__) \
      ->UseManualTime()                              \
      ->Iterations(1)                                \
      ->Unit(benchmark::kMillisecond)
PALPATE_FULL_SOLUTION(tet10_move, Element::kTet10, Contact::Kind::kDisplacement, 0.3);
PALPATE_FULL_SOLUTION(tet10_load, Element::kTet10, Contact::Kind::kForce, 0.3);
PALPATE_FULL_SOLUTION(tet10_mixed_move, Element::kTet10, Contact::Kind::kDisplacement, 0.499);
PALPATE_FULL_SOLUTION(tet4_move, Element::kTet4, Contact::Kind::kDisplacement, 0.45);
PALPATE_FULL_SOLUTION(tet4_load, Element::kTet4, Contact::Kind::kForce, 0.45);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
