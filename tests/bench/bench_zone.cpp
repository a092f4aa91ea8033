// Presses on a neo-Hookean slab by zones, against the full model of the same mesh. Discs of 3.4
// cells at random places are pressed by up to 30 % of their width, obliquely, in 60 updates. One
// thread, CPU time. Counters: `p50_us` and `p99_us` per update after the first of a press,
// `first_ms` that one, `condense_ms` of a new place, `full_over_update` the full model's time by
// p50; of the last update: `error_p95` [%] and `degrees_p95` against the full model, `covered` [%]
// with an error within the bound, `bound_by_error` its median, `valid` [%].
#include <algorithm>
#include <cmath>
#include <ctime>
#include <memory>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "slave/mechanics/fem/solid/solid_model.h"
#include "slave/mechanics/fem/zone/fem_zone_model.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kSide = 0.08, kModulus = 5000;  // [m], [Pa]
constexpr int kUpdates = 60;

// CPU time of this thread [s]: what other programs take does not count.
double Now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double Quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

struct Bodies {
  SolidMesh mesh;
  HeldNodes held;
  double width, height;  // of the discs, of the slab [m]
  std::unique_ptr<FemZoneModel> zone;
  std::unique_ptr<SolidModel> full;

  Bodies(int cells, double nu)
      : mesh(MeshBox({kSide, kSide, kSide * (cells / 2) / cells}, {cells, cells, cells / 2})),
        width(3.4 * kSide / cells),
        height(kSide * (cells / 2) / cells) {
    for (const Vector3d& p : mesh.nodes) {
      const bool bottom = p.z() == 0;
      held.push_back({bottom, bottom, bottom});
    }
    zone = std::make_unique<FemZoneModel>(mesh, held, kModulus, nu, FemZoneModel::Options{});
    SolidParams params;
    params.options.law = FemOptions::Law::kNeoHookean;
    params.young_modulus = kModulus;
    params.poisson_ratio = nu;
    params.density = 1000;
    full = std::make_unique<SolidModel>(mesh, held, params);
  }
};

// Apart by two and a half widths, where that many fit.
std::vector<Contact> RandomContacts(const Bodies& bodies, int count, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const double margin = 0.6 * bodies.width;
  std::vector<Contact> contacts;
  for (int tries = 0; static_cast<int>(contacts.size()) < count && tries < 10000; ++tries) {
    Contact contact;
    contact.width = bodies.width;
    contact.p_O = {margin + (kSide - 2 * margin) * unit(*random),
                   margin + (kSide - 2 * margin) * unit(*random), bodies.height};
    const double depth = bodies.width * (0.1 + 0.2 * unit(*random)), turn = 6.28 * unit(*random),
                 tangential = 0.5 * depth * unit(*random);
    contact.prescribed_O = {tangential * std::cos(turn), tangential * std::sin(turn), -depth};
    const bool clear = std::ranges::all_of(contacts, [&](const Contact& other) {
      return (other.p_O - contact.p_O).norm() > 2.5 * bodies.width;
    });
    if (clear) contacts.push_back(contact);
  }
  return contacts;
}

struct Tally {
  std::vector<double> update, first, condense, full, error, angle, ratio;
  int valid = 0, covered = 0;
};

void Press(Bodies& bodies, const std::vector<Contact>& contacts, Tally* tally) {
  std::vector<ContactResponse> got(contacts.size()), expected(contacts.size());
  double start = Now();
  bodies.zone->Prefetch(contacts);
  tally->condense.push_back((Now() - start) / static_cast<double>(contacts.size()));
  std::vector<Contact> now = contacts;
  for (int k = 1; k <= kUpdates; ++k) {
    for (std::size_t i = 0; i < now.size(); ++i) {
      now[i].prescribed_O = k * contacts[i].prescribed_O / kUpdates;
    }
    start = Now();
    bodies.zone->Respond(now, got);
    (k == 1 ? tally->first : tally->update).push_back(Now() - start);
  }
  bodies.full->Reset();
  start = Now();
  bodies.full->Respond(contacts, expected);
  tally->full.push_back(Now() - start);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (expected[i].validity == Validity::kFailed) continue;
    const Vector3d &f = got[i].force_O, &truth = expected[i].force_O;
    const double error = (f - truth).norm();
    tally->error.push_back(error / truth.norm());
    tally->angle.push_back(std::atan2(f.cross(truth).norm(), f.dot(truth)));
    tally->ratio.push_back(got[i].force_bound / error);
    tally->valid += got[i].validity == Validity::kValid ? 1 : 0;
    tally->covered += error <= got[i].force_bound ? 1 : 0;
  }
}

// Arguments: cells along the side, contacts, Poisson's ratio in percent.
void Presses(benchmark::State& state) {
  Bodies bodies(static_cast<int>(state.range(0)), 0.01 * static_cast<double>(state.range(2)));
  std::mt19937 random(5);
  Tally tally;
  for (auto _ : state) {
    Press(bodies, RandomContacts(bodies, static_cast<int>(state.range(1)), &random), &tally);
  }
  const double median = Quantile(tally.update, 0.5);
  const double all = 0.01 * static_cast<double>(tally.error.size());
  state.counters["tets"] = static_cast<double>(bodies.mesh.tets.size());
  state.counters["p50_us"] = 1e6 * median;
  state.counters["p99_us"] = 1e6 * Quantile(tally.update, 0.99);
  state.counters["first_ms"] = 1e3 * Quantile(tally.first, 0.5);
  state.counters["condense_ms"] = 1e3 * Quantile(tally.condense, 0.5);
  state.counters["full_over_update"] = Quantile(tally.full, 0.5) / median;
  state.counters["error_p95"] = 100 * Quantile(tally.error, 0.95);
  state.counters["degrees_p95"] = 57.2958 * Quantile(tally.angle, 0.95);
  state.counters["bound_by_error"] = Quantile(tally.ratio, 0.5);
  state.counters["covered"] = tally.covered / all;
  state.counters["valid"] = tally.valid / all;
}
BENCHMARK(Presses)
    ->Args({18, 1, 40})
    ->Args({18, 1, 45})
    ->Args({18, 3, 40})
    ->Iterations(20)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(Presses)
    ->Args({28, 1, 40})
    ->Args({28, 8, 40})
    ->Iterations(3)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
