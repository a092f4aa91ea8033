// Measures the cost of the mechanics for various sizes, on one thread. Counters: `ratio`: CPU time
// divided by that of a reference measured in the same run; `dof`: boundary unknowns; `allocations`:
// per update; `error`: error of the result.
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "tests/bench/timing.h"
#include "tests/slave/mechanics/bodies.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

Bem2dModel& ModelOf(int elements, ElementOrder order = ElementOrder::kConstant) {
  static std::map<std::pair<int, ElementOrder>, std::unique_ptr<Bem2dModel>> models;
  auto& model = models[{elements, order}];
  if (!model) {
    ReferenceProblem problem = bodies::Block(elements, 0.088, 0.49, Plane::kStress);
    problem.order = order;
    model = std::make_unique<Bem2dModel>(
        std::move(problem), Bem2dModel::Params{.young_modulus = 127e3, .thickness = 9e-3});
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
  contact.prescribed_O.head<2>() = -1e-3 * e.normal();
  return contact;
}

// `ratio`: time divided by that of Eigen's LU of the capacitance matrix alone.
void Report(benchmark::State& state, const Bem2dModel& model, long allocated, double seconds) {
  state.counters["ratio"] = seconds / static_cast<double>(state.iterations()) /
                            EigenLuSeconds(2 * static_cast<int>(state.range(0)), 2);
  state.counters["dof"] = static_cast<double>(model.info().dof);
  state.counters["allocations"] =
      static_cast<double>(allocated) / static_cast<double>(state.iterations());
}

// Two contact sets in turn, so that every update solves its capacitance matrix again.
void Alternate(benchmark::State& state, Bem2dModel& model, const std::vector<Contact>& one,
               const std::vector<Contact>& other) {
  std::vector<ContactResponse> responses(one.size());
  model.Respond(one, responses);
  model.Respond(other, responses);
  if (responses[0].validity == Validity::kFailed) state.SkipWithError("failed");
  const long before = AllocationCount();
  const double start = CpuSeconds();
  bool turn = false;
  for (auto _ : state) {
    model.Respond(turn ? one : other, responses);
    benchmark::DoNotOptimize(responses.data());
    turn = !turn;
  }
  Report(state, model, AllocationCount() - before, (CpuSeconds() - start));
}

// S contacts of one element each, every one at a random place within a separate part of the free
// boundary.
class RandomContacts {
 public:
  RandomContacts(const Bem2dModel& model, int S)
      : first_(FirstFreeElement(model)), step_((model.info().elements * 3 / 4 - 1) / S) {
    for (int k = 0; k < S; ++k) contacts_.push_back(Press(model, first_ + k * step_, 0));
  }
  std::vector<Contact>& contacts() { return contacts_; }
  void Move(std::size_t k) {
    Contact& contact = contacts_[k];
    // Chooses another element if there is more than one.
    const int element = first_ + static_cast<int>(k) * step_ + Below(step_);
    const bool same = element == contact.element && step_ > 1;
    contact.element = same ? first_ + static_cast<int>(k) * step_ + (element + 1) % step_ : element;
  }
  int Below(int end) {
    seed_ = seed_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<int>((seed_ >> 33) % static_cast<unsigned long long>(end));
  }

 private:
  int first_, step_;
  unsigned long long seed_ = 1;
  std::vector<Contact> contacts_;
};

enum class Change { kNone, kOneMoves, kOneComesOrGoes, kAllMove };

// Measures one update of the forces after each change.
template <Change change>
void Contacts(benchmark::State& state) {
  Bem2dModel& model = ModelOf(static_cast<int>(state.range(1)));
  const auto S = static_cast<std::size_t>(state.range(0));
  RandomContacts random(model, static_cast<int>(S));
  auto& contacts = random.contacts();
  std::vector<ContactResponse> responses(S);
  const Contact last = contacts.back();
  const auto next = [&](bool turn) {
    if (change == Change::kOneMoves) {
      random.Move(static_cast<std::size_t>(random.Below(static_cast<int>(S))));
    } else if (change == Change::kAllMove) {
      for (std::size_t k = 0; k < S; ++k) random.Move(k);
    } else if (change == Change::kNone) {
      for (auto& contact : contacts) contact.prescribed_O *= 0.999999;
    } else if (turn) {
      contacts.pop_back();
    } else {
      contacts.push_back(last);
    }
    model.Respond(contacts, std::span(responses).first(contacts.size()));
  };
  bool turn = true;
  for (int k = 0; k < 100; ++k, turn = !turn) next(turn);
  if (responses[0].validity == Validity::kFailed) state.SkipWithError("failed");
  const long before = AllocationCount();
  const double start = CpuSeconds();
  for (auto _ : state) {
    next(turn);
    turn = !turn;
    benchmark::DoNotOptimize(responses.data());
  }
  Report(state, model, AllocationCount() - before, (CpuSeconds() - start));
}

// Measures what accuracy costs on the block: the time of one update for a flat punch whose width is
// 1 / 15 of the side, and the error of its stiffness. Reference: paper A's block solved by graded
// finite elements of high order (nu = 0.49, plane stress, bonded, at the centre of the top),
// accurate to 2e-6.
void PunchOnTheBlock(benchmark::State& state) {
  constexpr double kSide = 0.088, kDepth = 1e-3, kStiffness = 0.41409130887689105;  // F / (E d t)
  const auto elements = static_cast<int>(state.range(0));
  Bem2dModel& model = ModelOf(elements, static_cast<ElementOrder>(state.range(1)));
  std::vector<Contact> contacts(1), elsewhere(1);
  contacts[0].p_O = {0.5 * kSide, kSide, 0};
  contacts[0].element = elements * 5 / 8;
  contacts[0].width = kSide / 15;
  contacts[0].prescribed_O = {0, -kDepth, 0};
  elsewhere = contacts;
  elsewhere[0].p_O.x() = 0.4 * kSide;
  elsewhere[0].element = elements * 5 / 8 + elements / 40;
  Alternate(state, model, contacts, elsewhere);
  std::vector<ContactResponse> response(1);
  model.Respond(contacts, response);
  const double k_bar = -response[0].force_O.y() / (127e3 * kDepth * 9e-3);
  state.counters["error"] = k_bar / kStiffness - 1;
  state.counters["precompute_ms"] = 1e3 * model.info().precompute_s;
}

// A flat tool is one contact, a round one as many as there are elements under it.
BENCHMARK(Contacts<Change::kNone>)->ArgNames({"S", "N"})->ArgsProduct({{1, 8}, {180, 2000}});
BENCHMARK(Contacts<Change::kOneMoves>)
    ->ArgNames({"S", "N"})
    ->ArgsProduct({{1, 2, 4, 8, 12, 16}, {180, 2000}});
BENCHMARK(Contacts<Change::kOneComesOrGoes>)
    ->ArgNames({"S", "N"})
    ->ArgsProduct({{8, 16}, {180, 2000}});
BENCHMARK(Contacts<Change::kAllMove>)->ArgNames({"S", "N"})->ArgsProduct({{1, 8, 16}, {180, 2000}});
BENCHMARK(PunchOnTheBlock)->ArgNames({"N", "order"})->ArgsProduct({{60, 180, 300, 540}, {0, 1, 2}});

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
