// Organs touched by several contacts that sink and circle at 100 mm/s, sampled at 100 Hz:
// neo-Hookean tetrahedra with four nodes, no precomputation. One thread, CPU time.
//
// `Kernel`: time for tangent, forces and energy per element [ns], in vector lanes and with the
// general element. `Slide/tetrahedra/contacts`: results over the bodies of organ_bodies.h: time of
// an update [ms]; error of the force relative to the converged one on the same mesh [%]; `within2`:
// share of errors within twice their estimate; `ratio`: median of estimated / true error; `failed`:
// number of failed updates; `steps` of Newton's method and their `iterations`; `first`: longest
// first touch [ms]; start [s]; memory [MB]. `Rub`: as `Slide`, for tools that slip with friction.
// `Before`: as `Slide`, for the general model with a residual of 1e-2, on the first body. All are
// measured in one run, because the load of machines varies.
#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <benchmark/benchmark.h>

#include "slave/mechanics/fem/fem_body.h"
#include "slave/mechanics/fem/fem_model.h"
#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mesh/index.h"
#include "tests/bench/organ_bodies.h"
#include "tests/bench/timing.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kModulus = 6000;   // [Pa]
constexpr double kWidth = 0.014;    // of the discs [m]
constexpr double kDepth = 0.004;    // [m]
constexpr double kStep = 0.001;     // of a contact per sample [m]
constexpr double kCircle = 0.003;   // radius of the tool's circular path [m]
constexpr double kResidual = 5e-2;  // one step of Newton's method per sample
constexpr int kSamples = 60;

FemOptions OptionsOf(double residual) {
  FemOptions options;
  options.law = FemOptions::Law::kNeoHookean;
  options.residual = residual;
  return options;
}

// `friction`: Coulomb's coefficient of tools that slip; 0: bonded.
FemModel::Params ParamsOf(double nu, double residual, double friction) {
  return {.material = {.young_modulus = kModulus, .poisson_ratio = nu},
          .options = OptionsOf(residual),
          .contact = friction > 0 ? ContactLaw::kFriction : ContactLaw::kBonded,
          .friction = friction};
}

std::vector<Contact> ContactsAt(const std::vector<organs::Place>& places, int sample) {
  const double way = kStep * sample, depth = std::min(kDepth, way);
  const double turn = std::max(0.0, way - kDepth) / kCircle;
  std::vector<Contact> contacts;
  for (const organs::Place& place : places) {
    const Vector3d across = place.normal.cross(place.along);
    contacts.push_back({.kind = Contact::Kind::kDisplacement, .p_O = place.p_O, .width = kWidth});
    contacts.back().prescribed_O =
        -depth * place.normal +
        kCircle * (std::sin(turn) * place.along + (1 - std::cos(turn)) * across);
  }
  return contacts;
}

struct Tally {
  std::vector<double> updates, errors, angles;  // [ms], [%], [deg]
  std::vector<double> ratios;                   // estimated by true error
  double start = 0, memory = 0, first = 0, steps = 0, iterations = 0;
  int failed = 0;

  void Compare(const ContactResponse& answer, const ContactResponse& expected) {
    if (expected.validity == Validity::kFailed) return;
    failed += answer.validity == Validity::kFailed;
    const Vector3d &F = answer.force_O, &G = expected.force_O;
    errors.push_back(100 * (F - G).norm() / G.norm());
    ratios.push_back(answer.force_error / (F - G).norm());
    angles.push_back(180 / M_PI * std::atan2(F.cross(G).norm(), F.dot(G)));
  }
  void Show(benchmark::State& state) const {
    state.counters["p50"] = Quantile(updates, 0.5);
    state.counters["p99"] = Quantile(updates, 0.99);
    state.counters["first"] = first;
    state.counters["start"] = start;
    if (memory > 0) state.counters["MB"] = memory;
    if (errors.empty()) return;
    const auto count = static_cast<double>(updates.size());
    state.counters["err95"] = Quantile(errors, 0.95);
    state.counters["errmax"] = Quantile(errors, 1);
    state.counters["deg95"] = Quantile(angles, 0.95);
    state.counters["failed"] = failed;
    const auto enough = std::ranges::count_if(ratios, [](double ratio) { return ratio >= 0.5; });
    state.counters["within2"] =
        100.0 * static_cast<double>(enough) / static_cast<double>(ratios.size());
    state.counters["ratio"] = Quantile(ratios, 0.5);
    if (steps > 0) state.counters["steps"] = steps / count;
    if (steps > 0) state.counters["iterations"] = iterations / count;
  }
};

void SlideOn(int number, int tets, int count, double nu, double friction, Tally* tally) {
  const organs::Body body = organs::MakeBody(number, tets);
  const auto places = organs::PlacesOn(body, count);
  double begin = CpuSeconds();
  FemModel model(body.mesh, body.held, ParamsOf(nu, kResidual, friction));
  tally->start = std::max(tally->start, CpuSeconds() - begin);
  FemModel converged(body.mesh, body.held, ParamsOf(nu, 1e-7, friction));
  std::vector<ContactResponse> answers(places.size()), expected(places.size());
  for (int sample = 1; sample <= kSamples; ++sample) {
    const auto contacts = ContactsAt(places, sample);
    begin = CpuSeconds();
    model.Respond(contacts, answers);
    tally->updates.push_back(1e3 * (CpuSeconds() - begin));
    if (sample == 1) tally->first = std::max(tally->first, tally->updates.back());
    tally->steps += model.newton_steps();
    tally->iterations += model.iterations();
    converged.Respond(contacts, expected);
    for (std::size_t k = 0; k < places.size(); ++k) tally->Compare(answers[k], expected[k]);
  }
  tally->memory = std::max(tally->memory, 1e-6 * static_cast<double>(model.info().memory_bytes));
}

// All bodies, one Poisson's ratio each.
void Slide(benchmark::State& state, double friction) {
  const int tets = static_cast<int>(state.range(0)), count = static_cast<int>(state.range(1));
  for (auto _ : state) {
    Tally tally;
    constexpr double kRatios[] = {0.3, 0.45, 0.48};
    for (int body = 0; body < organs::kBodies; ++body) {
      SlideOn(body, tets, count, kRatios[body % 3], friction, &tally);
    }
    tally.Show(state);
    state.SetIterationTime(1e-3 * Quantile(tally.updates, 0.5));
  }
}

void Before(benchmark::State& state) {
  const organs::Body body = organs::MakeBody(0, static_cast<int>(state.range(0)));
  const auto places = organs::PlacesOn(body, static_cast<int>(state.range(1)));
  SolidModel::Params params;
  params.options = OptionsOf(1e-2);
  params.young_modulus = kModulus;
  params.poisson_ratio = 0.45;
  for (auto _ : state) {
    Tally tally;
    double begin = CpuSeconds();
    SolidModel model(body.mesh, body.held, params);
    tally.start = CpuSeconds() - begin;
    std::vector<ContactResponse> answers(places.size());
    for (int sample = 1; sample <= kSamples; ++sample) {
      const auto contacts = ContactsAt(places, sample);
      begin = CpuSeconds();
      model.Respond(contacts, answers);
      tally.updates.push_back(1e3 * (CpuSeconds() - begin));
    }
    tally.Show(state);
    state.SetIterationTime(1e-3 * Quantile(tally.updates, 0.5));
  }
}

void Kernel(benchmark::State& state) {
  const organs::Body organ = organs::MakeBody(1, 20'000);
  const TetMesh mesh = MakeTetMesh(organ.mesh, 4, LargerSide(organ.mesh.nodes));
  const BlockLayout layout(mesh, false);
  const ElasticBody general(mesh, layout, MaterialLaw(FemOptions::Law::kNeoHookean, 0.45));
  Eigen::VectorXd x = 1e-3 * Eigen::VectorXd::Random(layout.size()), gradient = x;
  SparseMatrix matrix = layout.pattern();
  fem::FemBody body(organ.mesh, organ.held, {0.45, fem::TetElements::Law::kNeoHookean});
  fem::NodeVector u(Index(body.size()));
  fem::BlockMatrix tangent(body.pattern());
  constexpr int kTimes = 20;
  for (auto _ : state) {
    const double begin = CpuSeconds();
    for (int k = 0; k < kTimes; ++k) {
      benchmark::DoNotOptimize(general.Energy(x, &gradient));
      general.AddTangent(x, kExactTangent, false, &matrix);
    }
    const double between = CpuSeconds();
    for (int k = 0; k < kTimes; ++k) {
      benchmark::DoNotOptimize(body.EvaluateWithTangent(u, 0, tangent).energy);
    }
    const double per_element = 1e9 / (kTimes * static_cast<double>(organ.mesh.tets.size()));
    state.counters["general"] = per_element * (between - begin);
    state.counters["lanes"] = per_element * (CpuSeconds() - between);
    state.SetIterationTime(CpuSeconds() - between);
  }
}

BENCHMARK(Kernel)->UseManualTime()->Iterations(1)->Unit(benchmark::kMillisecond);
BENCHMARK(Before)
    ->ArgsProduct({{20'000, 70'000}, {1, 4}})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Slide, Rub, 0.3)
    ->Name("Rub")
    ->ArgsProduct({{20'000}, {1, 2, 4, 8}})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(Slide, Slide, 0.0)
    ->Name("Slide")
    ->ArgsProduct({{20'000, 70'000, 100'000}, {1, 2, 4, 8}})
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
