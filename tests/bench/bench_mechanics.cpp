// Cost of the mechanics against size. One thread. Counters: `ratio` is the CPU time over that of a
// reference measured in the same run; `dof` the boundary unknowns; `allocations` per update.
#include <array>
#include <ctime>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/LU>
#include <benchmark/benchmark.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

// CPU time of this thread [s]: what other programs take does not count.
double Now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

ReferenceProblem Block(int elements) {
  ReferenceProblem problem{MeshRectangle(0.088, 0.088, elements), {}, 0.49, Plane::kStress};
  for (const auto& e : problem.mesh.elements) {
    const bool bottom = e.midpoint().y() < 1e-9;
    problem.held.push_back({bottom, bottom});
  }
  return problem;
}

Bem2dModel& ModelOf(int elements) {
  static std::map<int, std::unique_ptr<Bem2dModel>> models;
  auto& model = models[elements];
  if (!model) {
    model = std::make_unique<Bem2dModel>(
        Block(elements), Bem2dModel::Params{.young_modulus = 127e3, .thickness = 9e-3});
  }
  return *model;
}

int FirstFreeElement(const Bem2dModel& model) {
  int i = 0;
  while (model.greens_functions().held(i, 0)) ++i;
  return i;
}

Contact Press(const Bem2dModel& model, int element, int neighbours) {
  const auto& mesh = model.greens_functions().problem().mesh;
  const auto& e = mesh.elements[static_cast<std::size_t>(element)];
  Contact contact;
  contact.element = element;
  contact.p_O.head<2>() = e.midpoint();
  contact.width = neighbours * e.length();
  contact.value_O.head<2>() = -1e-3 * e.normal();
  return contact;
}

// Seconds of a dense solution with `order` unknowns by Eigen's LU, two right-hand sides.
double EigenLuSeconds(int order) {
  static std::map<int, double> measured;
  double& seconds = measured[order];
  if (seconds == 0) {
    const Eigen::MatrixXd A =
        Eigen::MatrixXd::Random(order, order) + order * Eigen::MatrixXd::Identity(order, order);
    const Eigen::MatrixXd b = Eigen::MatrixXd::Random(order, 2);
    constexpr int kTimes = 1000;
    const double start = Now();
    for (int k = 0; k < kTimes; ++k) {
      Eigen::MatrixXd x = A.partialPivLu().solve(b);
      benchmark::DoNotOptimize(x.data());
    }
    seconds = (Now() - start) / kTimes;
  }
  return seconds;
}

// `ratio`: over Eigen's LU of the capacitance matrix alone.
void Report(benchmark::State& state, const Bem2dModel& model, long allocated, double seconds) {
  state.counters["ratio"] = seconds / static_cast<double>(state.iterations()) /
                            EigenLuSeconds(2 * static_cast<int>(state.range(0)));
  state.counters["dof"] = static_cast<double>(model.info().dof);
  state.counters["allocations"] =
      static_cast<double>(allocated) / static_cast<double>(state.iterations());
}

// Two contact sets in turn, so that every update solves its capacitance matrix anew.
void Alternate(benchmark::State& state, Bem2dModel& model, const std::vector<Contact>& one,
               const std::vector<Contact>& other) {
  std::vector<ContactResponse> responses(one.size());
  model.Respond(one, responses);
  model.Respond(other, responses);
  if (responses[0].validity == Validity::kFailed) state.SkipWithError("failed");
  const long before = AllocationCount();
  const double start = Now();
  bool turn = false;
  for (auto _ : state) {
    model.Respond(turn ? one : other, responses);
    benchmark::DoNotOptimize(responses.data());
    turn = !turn;
  }
  Report(state, model, AllocationCount() - before, (Now() - start));
}

// One patch of S elements, moving along the boundary.
void OnePatch(benchmark::State& state) {
  Bem2dModel& model = ModelOf(static_cast<int>(state.range(1)));
  const auto S = static_cast<int>(state.range(0));
  const int first = FirstFreeElement(model) + S;
  // An even number of midpoints lies within S - 1 lengths of a place between two elements.
  const auto patch = [&](int element) {
    Contact contact = Press(model, element, S - 1);
    const auto& e =
        model.greens_functions().problem().mesh.elements[static_cast<std::size_t>(element)];
    if (S % 2 == 0) contact.p_O.head<2>() = e.a;
    return std::vector<Contact>{contact};
  };
  Alternate(state, model, patch(first), patch(first + 1));
}

// S patches of one element each, spread over the free boundary, each with its own stiffness.
void SeparateContacts(benchmark::State& state) {
  Bem2dModel& model = ModelOf(static_cast<int>(state.range(1)));
  const auto S = static_cast<int>(state.range(0));
  const int first = FirstFreeElement(model);
  const int step = (model.info().elements * 3 / 4 - 1) / S;
  std::vector<Contact> one, other;
  for (int k = 0; k < S; ++k) {
    one.push_back(Press(model, first + k * step, 0));
    other.push_back(Press(model, first + k * step + 1, 0));
  }
  Alternate(state, model, one, other);
}

// The same set again with other values: the next camera picture while a contact is held.
void UnchangedContacts(benchmark::State& state) {
  Bem2dModel& model = ModelOf(static_cast<int>(state.range(1)));
  const auto S = static_cast<int>(state.range(0));
  const int first = FirstFreeElement(model);
  const int step = (model.info().elements * 3 / 4 - 1) / S;
  std::vector<Contact> contacts;
  for (int k = 0; k < S; ++k) contacts.push_back(Press(model, first + k * step, 0));
  std::vector<ContactResponse> responses(contacts.size());
  model.Respond(contacts, responses);
  if (responses[0].validity == Validity::kFailed) state.SkipWithError("failed");
  const long before = AllocationCount();
  const double start = Now();
  for (auto _ : state) {
    for (auto& contact : contacts) contact.value_O *= 0.999999;
    model.Respond(contacts, responses);
    benchmark::DoNotOptimize(responses.data());
  }
  Report(state, model, AllocationCount() - before, (Now() - start));
}

double LuAndInverseSeconds(int order) {
  static std::map<int, double> measured;
  double& seconds = measured[order];
  if (seconds == 0) {
    const Eigen::MatrixXd A =
        Eigen::MatrixXd::Random(order, order) + 10 * Eigen::MatrixXd::Identity(order, order);
    const double start = Now();
    Eigen::MatrixXd inverse = A.partialPivLu().inverse();
    benchmark::DoNotOptimize(inverse.data());
    seconds = Now() - start;
  }
  return seconds;
}

// Green's functions: assembly, factorisation, solution, condition; ratio to LU + inverse by Eigen.
void Precompute(benchmark::State& state) {
  const auto elements = static_cast<int>(state.range(0));
  const double reference = LuAndInverseSeconds(2 * elements);
  double seconds = 0;
  for (auto _ : state) {
    const double start = Now();
    const GreensFunctions greens(Block(elements));
    benchmark::DoNotOptimize(greens.block(0, 0));
    seconds += Now() - start;
  }
  state.counters["dof"] = 2 * elements;
  state.counters["ratio"] = seconds / static_cast<double>(state.iterations()) / reference;
}

BENCHMARK(OnePatch)->ArgNames({"S", "N"})->Args({1, 60})->Args({1, 500})->Args({1, 2000});
BENCHMARK(OnePatch)->ArgNames({"S", "N"})->Args({16, 120})->Args({16, 500})->Args({16, 2000});
BENCHMARK(SeparateContacts)->ArgNames({"S", "N"})->ArgsProduct({{1, 4, 16}, {60, 180, 500, 2000}});
BENCHMARK(UnchangedContacts)->ArgNames({"S", "N"})->ArgsProduct({{1, 16}, {60, 500, 2000}});
BENCHMARK(Precompute)
    ->ArgName("N")
    ->Arg(60)
    ->Arg(180)
    ->Arg(500)
    ->Arg(1000)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
