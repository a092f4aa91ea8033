// Cost of contacts on surface Green's functions against mesh size and number of contacts. Uses one
// thread and computes only forces. Counters: `dof`: unknowns of the finite elements. `us`: CPU time
// per update. `ratio`: that time divided by the time of Eigen's LU and solution of the same
// capacitance matrix, measured in the same run. `error`: error of the forces relative to a fresh
// factorisation.
#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include <benchmark/benchmark.h>

#include "slave/mechanics/fem/green/fem_green_model.h"
#include "slave/mechanics/relaxation/relaxing_model.h"
#include "tests/bench/timing.h"
#include "tests/support/fixed_nodes.h"

namespace palpate {
namespace {

struct Held {
  SolidMesh mesh;
  HeldNodes held;
};

Held Cube(int cells) {
  const SolidMesh mesh = MeshBox({0.06, 0.06, 0.06}, {cells, cells, cells});
  return {mesh, FixedWhere(mesh, [](const Eigen::Vector3d& p) { return p.z() == 0; })};
}

// A model and contacts at random places, one node each. Their columns are computed already.
struct Ready {
  std::unique_ptr<FemGreenModel> model;
  std::vector<Contact> contacts;
};

Ready& ReadyOf(int cells) {
  static std::map<int, Ready> all;
  Ready& ready = all[cells];
  if (ready.model) return ready;
  const Held cube = Cube(cells);
  ready.model =
      std::make_unique<FemGreenModel>(cube.mesh, cube.held, 3800, 0.15, FemGreenModel::Options{});
  std::mt19937 random(1);
  const SurfaceMesh& surface = ready.model->surface();
  std::vector<int> triangle_of_node(surface.nodes.size(), -1);
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    for (const int n : surface.triangles[t]) {
      triangle_of_node[static_cast<std::size_t>(n)] = static_cast<int>(t);
    }
  }
  const auto& node_of_place = ready.model->columns().node_of_place();
  const int groups = static_cast<int>(node_of_place.size()) / GreenColumns::kGroup;
  std::vector<int> order(static_cast<std::size_t>(groups));
  for (int g = 0; g < groups; ++g) order[static_cast<std::size_t>(g)] = g;
  std::ranges::shuffle(order, random);
  order.resize(static_cast<std::size_t>(std::min(groups, 40)));
  for (const int g : order) {
    for (int k = 0; k < GreenColumns::kGroup; ++k) {
      const int node = node_of_place[static_cast<std::size_t>(g * GreenColumns::kGroup + k)];
      if (cube.held[static_cast<std::size_t>(node)][0]) continue;
      Contact contact;
      contact.element = triangle_of_node[static_cast<std::size_t>(node)];
      contact.p_O = surface.nodes[static_cast<std::size_t>(node)];
      contact.prescribed_O = {1e-4, -2e-4, 3e-4};
      ready.contacts.push_back(contact);
      ready.model->Prefetch({&contact, 1});
    }
  }
  std::ranges::shuffle(ready.contacts, random);
  return ready;
}

// Time of an update in the fastest of 15 batches [s].
double SecondsPer(DeformationModel& model, std::vector<Contact> contacts) {
  constexpr int kTimes = 2000;
  std::vector<ContactResponse> responses(contacts.size());
  double best = 1;
  for (int batch = 0; batch < 15; ++batch) {
    const double start = CpuSeconds();
    for (int k = 0; k < kTimes; ++k) {
      for (Contact& contact : contacts) contact.prescribed_O *= k % 2 == 0 ? 1.01 : 1 / 1.01;
      model.Respond(contacts, responses);
    }
    best = std::min(best, (CpuSeconds() - start) / kTimes);
  }
  return best;
}

// `ratio`: time of a step of a relaxing body divided by that of the elastic update of the same
// contacts, including stiffnesses, for various numbers of contacts and terms.
void Relaxation(benchmark::State& state) {
  Ready& ready = ReadyOf(6);
  const auto count = std::min(ready.contacts.size(), static_cast<std::size_t>(state.range(0)));
  std::vector<Contact> contacts(ready.contacts.begin(),
                                ready.contacts.begin() + static_cast<std::ptrdiff_t>(count));
  const Held cube = Cube(6);
  const std::vector<RelaxationTerm> terms(static_cast<std::size_t>(state.range(1)), {0.1, 0.5});
  RelaxingModel relaxing(
      std::make_unique<FemGreenModel>(cube.mesh, cube.held, 3800, 0.15, FemGreenModel::Options{}),
      terms, 0.01);
  relaxing.Prefetch(contacts);
  for (auto _ : state) {
    const double elastic = SecondsPer(*ready.model, contacts);
    const double relaxed = SecondsPer(relaxing, contacts);
    state.counters["us"] = 1e6 * relaxed;
    state.counters["ratio"] = relaxed / elastic;
  }
}
BENCHMARK(Relaxation)->ArgsProduct({{1, 5, 30, 100}, {2, 8}})->Iterations(1);

double ErrorOf(const Ready& ready, const std::vector<Contact>& contacts,
               const std::vector<ContactResponse>& got) {
  GreenColumns& columns = ready.model->columns();
  SurfaceNodePlaces places(columns.stiffness().elements, columns.length_unit(),
                           columns.place_of_node(), {});
  ComplianceSolver fresh(ready.model->columns(), places,
                         {.young_modulus = 3800, .larger_side = 0.06});
  std::vector<ContactResponse> reference(contacts.size());
  fresh.Respond(contacts, reference);
  double error = 0, largest = 0;
  for (std::size_t i = 0; i < got.size(); ++i) {
    error = std::max(error, (got[i].force_O - reference[i].force_O).norm());
    largest = std::max(largest, reference[i].force_O.norm());
  }
  return error / largest;
}

enum class Turn { kUnchanged, kOneMoves, kAllMove };

void Contacts(benchmark::State& state, Turn turn) {
  Ready& ready = ReadyOf(static_cast<int>(state.range(1)));
  const auto S = static_cast<std::size_t>(state.range(0));
  const std::size_t count = ready.contacts.size();
  const bool all = turn == Turn::kAllMove;
  std::vector<Contact> contacts(ready.contacts.begin(),
                                ready.contacts.begin() + static_cast<long>(S));
  std::vector<ContactResponse> responses(S);
  std::mt19937 random(2);
  std::vector<std::size_t> dice(4096);
  for (auto& d : dice) d = random() % S;
  std::size_t next = S, round = 0;
  ready.model->Respond(contacts, responses);
  double least = 1;
  for (auto _ : state) {
    constexpr int kBatch = 256;
    const double start = CpuSeconds();
    for (int k = 0; k < kBatch; ++k) {
      const std::size_t moved = all ? S : turn == Turn::kOneMoves ? 1 : 0;
      for (std::size_t m = 0; m < moved; ++m) {
        // Contacts exchange their places with unused ones of the pool, so that no two are at the
        // same place.
        const std::size_t i = moved == S ? m : dice[round++ % dice.size()];
        const Contact out = contacts[i];
        contacts[i] = ready.contacts[next % count];
        ready.contacts[next % count] = out;
        next = next + 1 == count ? S : next + 1;
      }
      ready.model->Respond(contacts, responses);
      benchmark::DoNotOptimize(responses.data());
    }
    least = std::min(least, (CpuSeconds() - start) / kBatch);
    if (responses[0].validity == Validity::kFailed) state.SkipWithError("failed");
  }
  std::copy(contacts.begin(), contacts.end(), ready.contacts.begin());
  state.counters["us"] = 1e6 * least;
  state.counters["ratio"] = least / EigenLuSeconds(static_cast<int>(3 * S), 1);
  state.counters["error"] = ErrorOf(ready, contacts, responses);
  state.counters["dof"] = static_cast<double>(ready.model->info().dof);
}

void Unchanged(benchmark::State& state) {
  Contacts(state, Turn::kUnchanged);
}
void OneMoves(benchmark::State& state) {
  Contacts(state, Turn::kOneMoves);
}
void AllMove(benchmark::State& state) {
  Contacts(state, Turn::kAllMove);
}

void Sizes(benchmark::internal::Benchmark* benchmark) {
  for (const int cells : {8, 16, 26}) {
    for (const int S : {1, 2, 8, 16, 64}) benchmark->Args({S, cells});
  }
  benchmark->MinTime(0.1)->Unit(benchmark::kMicrosecond);
}
BENCHMARK(Unchanged)->Apply(Sizes);
BENCHMARK(OneMoves)->Apply(Sizes);
BENCHMARK(AllMove)->Apply(Sizes);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
