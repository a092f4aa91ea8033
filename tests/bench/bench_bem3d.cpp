// Cost of `bem3d` against its degrees of freedom. One thread. Counters: `ratio` is the CPU time
// over that of a reference measured in the same run; `error` the accuracy that it buys.
#include <algorithm>
#include <ctime>
#include <map>
#include <memory>
#include <random>
#include <vector>

#include <Eigen/LU>
#include <benchmark/benchmark.h>

#include "slave/mechanics/bem3d/bem3d_model.h"
#include "slave/mechanics/linear/dense_lu.h"
#include "tests/slave/mechanics/bem3d/solid_bodies.h"

namespace palpate {
namespace {

// CPU time of this thread [s]: what other programs take does not count.
double Now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

bool AtBottom(const Eigen::Vector3d& p) {
  return p.z() < 1e-9;
}

SurfaceMesh Cube(int cells) {
  return solid_bodies::Box({0.06, 0.06, 0.06}, {cells, cells, cells});
}

ReferenceSystem SystemOf(int cells) {
  const SurfaceMesh mesh = Cube(cells);
  return {mesh, solid_bodies::HeldWhere(mesh, AtBottom), 0.15};
}

// Integrals of the system alone.
void Assembly(benchmark::State& state) {
  const ReferenceSystem system = SystemOf(static_cast<int>(state.range(0)));
  double seconds = 0;
  for (auto _ : state) {
    const double start = Now();
    const Eigen::MatrixXd A = system.Matrix([](int) {});
    seconds += Now() - start;
    benchmark::DoNotOptimize(A.data());
  }
  const double pairs = static_cast<double>(system.triangles()) * system.triangles();
  state.counters["dof"] = 3 * system.triangles();
  state.counters["ns_per_pair"] = 1e9 * seconds / static_cast<double>(state.iterations()) / pairs;
}
BENCHMARK(Assembly)->Arg(4)->Arg(6)->Arg(9)->Arg(13)->Unit(benchmark::kMillisecond);

// LU and as many solutions as there are unknowns, without the integrals. `ratio`: over Eigen's LU
// and inverse of the same matrix. `error`: of A times the inverse, per entry.
void LuAndInverse(benchmark::State& state) {
  const ReferenceSystem system = SystemOf(static_cast<int>(state.range(0)));
  const Eigen::MatrixXd A = system.Matrix([](int) {});
  const Eigen::Index n = A.cols();
  const double start = Now();
  Eigen::MatrixXd reference = A.partialPivLu().inverse();
  const double eigen_seconds = Now() - start;
  benchmark::DoNotOptimize(reference.data());
  Eigen::MatrixXd inverse(n, n);
  double seconds = 0;
  for (auto _ : state) {
    inverse.setIdentity();
    const double begin = Now();
    DenseLu lu(A);
    while (lu.done() < lu.blocks()) lu.FactorizeNext();
    for (Eigen::Index j = 0; j < n; j += 192) {
      lu.SolveInPlace(inverse.middleCols(j, std::min<Eigen::Index>(192, n - j)));
    }
    seconds += Now() - begin;
  }
  state.counters["dof"] = static_cast<double>(n);
  state.counters["ratio"] = seconds / static_cast<double>(state.iterations()) / eigen_seconds;
  state.counters["error"] =
      (A * inverse.leftCols(10) - Eigen::MatrixXd::Identity(n, 10)).cwiseAbs().maxCoeff();
}
BENCHMARK(LuAndInverse)
    ->Arg(4)
    ->Arg(6)
    ->Arg(7)
    ->Arg(9)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

Bem3dModel& ModelOf(int cells) {
  static std::map<int, std::unique_ptr<Bem3dModel>> models;
  auto& model = models[cells];
  if (!model) {
    const SurfaceMesh mesh = Cube(cells);
    model = std::make_unique<Bem3dModel>(mesh, solid_bodies::HeldWhere(mesh, AtBottom), 3800, 0.15,
                                         Bem3dModel::Options{});
  }
  return *model;
}

// `count` different free triangles, pressed.
std::vector<Contact> RandomContacts(const Bem3dModel& model, int count, bool stiffness,
                                    std::mt19937* random) {
  const auto& system = model.greens().system();
  std::vector<int> free;
  for (int i = 0; i < system.triangles(); ++i) {
    if (!system.held(i, 0)) free.push_back(i);
  }
  std::ranges::shuffle(free, *random);
  std::vector<Contact> contacts(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    contacts[k].element = free[k];
    contacts[k].prescribed_O = {0, 0, -1e-4};
    contacts[k].wants_stiffness = stiffness;
  }
  return contacts;
}

// Every contact at another random place each time: gather, factorise, solve.
void ContactsMoved(benchmark::State& state) {
  Bem3dModel& model = ModelOf(static_cast<int>(state.range(0)));
  const int count = static_cast<int>(state.range(1));
  std::mt19937 random(1);
  std::vector<std::vector<Contact>> sets;
  for (int k = 0; k < 64; ++k) {
    sets.push_back(RandomContacts(model, count, state.range(2) != 0, &random));
  }
  std::vector<ContactResponse> responses(static_cast<std::size_t>(count));
  std::size_t k = 0;
  for (auto _ : state) model.Respond(sets[k++ % sets.size()], responses);
  state.counters["dof"] = static_cast<double>(model.info().dof);
  state.counters["S"] = count;
}
BENCHMARK(ContactsMoved)
    ->ArgNames({"cells", "S", "stiffness"})
    ->ArgsProduct({{4, 9}, {1, 8, 64}, {0, 1}})
    ->Unit(benchmark::kMicrosecond);

// The same places, other displacements.
void ContactsUnchanged(benchmark::State& state) {
  Bem3dModel& model = ModelOf(static_cast<int>(state.range(0)));
  const int count = static_cast<int>(state.range(1));
  std::mt19937 random(1);
  auto contacts = RandomContacts(model, count, false, &random);
  std::vector<ContactResponse> responses(static_cast<std::size_t>(count));
  for (auto _ : state) {
    contacts[0].prescribed_O.z() = -contacts[0].prescribed_O.z();
    model.Respond(contacts, responses);
  }
  state.counters["dof"] = static_cast<double>(model.info().dof);
  state.counters["S"] = count;
}
BENCHMARK(ContactsUnchanged)->ArgsProduct({{4, 9}, {1, 8, 64}})->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
