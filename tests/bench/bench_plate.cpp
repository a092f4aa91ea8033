// Cost of the plate models against their size, with the error beside it. One thread, CPU time.
// Counters: `dof` the modes that take part; `error` of the force against order 24; `ratio` the time
// over that of one Cholesky factorisation with as many unknowns, measured in the same run.
#include <cmath>
#include <ctime>
#include <map>
#include <memory>
#include <vector>

#include <Eigen/Cholesky>
#include <benchmark/benchmark.h>

#include "slave/mechanics/plate/fit/load_fit.h"
#include "slave/mechanics/plate/plate_large_model.h"
#include "slave/mechanics/plate/plate_model.h"

namespace palpate {
namespace {

using Eigen::Vector2d;

// The rubber membrane of paper C, 1 mm thick, under a tool 4 mm wide.
constexpr double kRadius = 0.039, kThickness = 0.001, kModulus = 27.2e6, kNu = 0.45;
constexpr double kWidth = 0.004;

PlateLargeModel& LargeOf(int order) {
  static std::map<int, std::unique_ptr<PlateLargeModel>> models;
  auto& model = models[order];
  if (!model) {
    model = std::make_unique<PlateLargeModel>(
        PlateLargeModel::Params{kRadius, kThickness, kModulus, kNu, 0, order});
  }
  return *model;
}

Contact Press(const Vector2d& p, double depth) {
  return {Contact::Kind::kDisplacement, {p.x(), p.y(), 0}, -1, kWidth, {0, 0, -depth}};
}

double Force(PlateLargeModel& model, const Vector2d& p, double depth) {
  const Contact contact = Press(p, depth);
  ContactResponse response;
  model.Respond(std::span(&contact, 1), std::span(&response, 1));
  return response.force_O.z();
}

double Now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double CholeskySeconds(int size) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(size, size) * size;
  Eigen::LLT<Eigen::MatrixXd> factor(size);
  constexpr int kTimes = 50;
  const double start = Now();
  for (int k = 0; k < kTimes; ++k) {
    factor.compute(A);
    benchmark::DoNotOptimize(factor.matrixLLT().data());
  }
  return (Now() - start) / kTimes;
}

// S contacts on a spiral, all moved at every update; the places change too.
void PlateUpdate(benchmark::State& state) {
  PlateModel model({kRadius, kThickness, kModulus, kNu});
  const auto count = static_cast<int>(state.range(0));
  std::vector<Contact> contacts;
  for (int i = 0; i < count; ++i) {
    const double r = 0.8 * kRadius * std::sqrt((i + 0.5) / count), angle = 2.399963 * i;
    contacts.push_back(Press({r * std::cos(angle), r * std::sin(angle)}, 1e-4));
    contacts.back().width = 0;
  }
  std::vector<ContactResponse> responses(contacts.size());
  double shift = 0;
  for (auto _ : state) {
    shift = shift > 1e-4 ? 0 : shift + 1e-6;
    contacts[0].p_O.x() += shift > 0 ? 1e-6 : -1e-4;
    model.Respond(contacts, responses);
    benchmark::DoNotOptimize(responses.data());
  }
  state.counters["contacts"] = count;
}
BENCHMARK(PlateUpdate)->Arg(1)->Arg(4)->Arg(16)->Arg(64);

// A tool that slides and presses, off centre, about 5 thicknesses deep: 20 um and 10 um a step.
void PlateLargeUpdate(benchmark::State& state) {
  const auto order = static_cast<int>(state.range(0));
  PlateLargeModel& model = LargeOf(order);
  int step = 0;
  const double start = Now();
  for (auto _ : state) {
    step = (step + 1) % 200;
    const int back = std::abs(step - 100);
    benchmark::DoNotOptimize(Force(model, {0.017 + 2e-5 * back, 0.006}, 4e-3 + 1e-5 * back));
  }
  const double seconds = (Now() - start) / static_cast<double>(state.iterations());
  const int modes = (order / 2 + 1) * (order / 2 + 1);
  const Vector2d place(0.0195, 0);
  state.counters["dof"] = modes;
  state.counters["ratio"] = seconds / CholeskySeconds(modes);
  state.counters["error"] =
      std::abs(Force(model, place, 5e-3) / Force(LargeOf(24), place, 5e-3) - 1);
}
BENCHMARK(PlateLargeUpdate)->Arg(6)->Arg(8)->Arg(12)->Arg(16)->Arg(20);

// The same at the centre, where no modes are needed.
void PlateLargeCentral(benchmark::State& state) {
  PlateLargeModel& model = LargeOf(12);
  int step = 0;
  for (auto _ : state) {
    step = (step + 1) % 200;
    benchmark::DoNotOptimize(Force(model, {0, 0}, 4e-3 + 1e-5 * std::abs(step - 100)));
  }
}
BENCHMARK(PlateLargeCentral);

void PlateLargePrecompute(benchmark::State& state) {
  const auto order = static_cast<int>(state.range(0));
  for (auto _ : state) {
    const PlateLargeModel model({kRadius, kThickness, kModulus, kNu, 0, order});
    state.counters["dof"] = static_cast<double>(model.info().dof);
    state.counters["MB"] = 1e-6 * static_cast<double>(model.info().memory_bytes);
  }
}
BENCHMARK(PlateLargePrecompute)->Arg(8)->Arg(12)->Arg(16)->Arg(24)->Unit(benchmark::kMillisecond);

// The load of a slowly moving tool from 31 dots; `error` in its place by the radius.
void Fit(benchmark::State& state, PlateSurface& plate, double force) {
  LoadFitter fitter(plate, kWidth);
  std::vector<Vector2d> dots;
  for (int i = -3; i <= 3; ++i) {
    for (int j = -2; j <= 2; ++j) dots.emplace_back(0.005 * i, 0.005 * j);
  }
  dots.resize(31);
  const std::vector<double> sigma(dots.size(), 2e-5);
  std::vector<std::vector<double>> pictures;
  std::vector<Vector2d> places;
  for (int k = 0; k < 20; ++k) {
    places.emplace_back(0.008 + 2e-4 * std::abs(k - 10), 0.004);
    const Contact load{
        Contact::Kind::kForce, {places.back().x(), 0.004, 0}, -1, kWidth, {0, 0, -force}};
    Solution solution;
    plate.Solve({&load, 1}, &solution);
    pictures.emplace_back();
    for (const auto& dot : dots) pictures.back().push_back(plate.Displacement(solution, dot));
  }
  std::size_t k = 0;
  double worst = 0;
  for (auto _ : state) {
    k = (k + 1) % pictures.size();
    const LoadFit fit = fitter.Fit(dots, pictures[k], sigma);
    worst = std::max(worst, (fit.p_O - places[k]).norm() / kRadius);
  }
  state.counters["error"] = worst;
}

void PlateFit(benchmark::State& state) {
  PlateModel plate({kRadius, kThickness, kModulus, kNu});
  Fit(state, plate, 0.03);
}
BENCHMARK(PlateFit);

void PlateLargeFit(benchmark::State& state) {
  Fit(state, LargeOf(static_cast<int>(state.range(0))), 3);
}
BENCHMARK(PlateLargeFit)->Arg(8)->Arg(12);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
