// Cost of force networks per sample. One thread. Counters: `kHz` samples per second; `ratio` the
// time over that of a multiplication of matrices with as many multiply-adds as the windows need, in
// the same run and instructions; `error` the largest difference from the formulas in double
// precision, relative to outputs of order 1.
#include <algorithm>
#include <array>
#include <ctime>
#include <memory>

#include <Eigen/Core>
#include <benchmark/benchmark.h>

#include "tests/slave/tactile/network/reference_network.h"

namespace palpate {
namespace {

constexpr int kWindow = 50, kUnits = 20;

// CPU time of this thread [s]: what other programs take does not count.
double Now() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Seconds for the sums of one sample in `lanes` windows, as products of matrices by Eigen: the best
// of many.
double ProductSeconds(int lanes) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Random(lanes, kUnits),
                        two = Eigen::MatrixXd::Random(lanes, 2 * kUnits),
                        W1 = Eigen::MatrixXd::Random(kUnits, 4 * kUnits),
                        W2 = Eigen::MatrixXd::Random(2 * kUnits, 4 * kUnits);
  Eigen::MatrixXd z(lanes, 4 * kUnits);
  double best = 1;
  for (int k = 0; k < 300; ++k) {
    const double start = Now();
    for (int i = 0; i < 10; ++i) {
      z.noalias() = one * W1;
      benchmark::DoNotOptimize(z.data());
      z.noalias() = two * W2;
      benchmark::DoNotOptimize(z.data());
    }
    best = std::min(best, (Now() - start) / 10);
  }
  return best;
}

const RandomNetwork& Network(const std::string& architecture) {
  static const RandomNetwork recurrent = MakeRandomNetwork("rnn_21", kUnits, 0.3f, 1);
  static const RandomNetwork forward = MakeRandomNetwork("dnn_21", kUnits, 0.3f, 1);
  return IsRecurrent(architecture) ? recurrent : forward;
}

const std::vector<TactileSignals>& Signals() {
  static const auto signals = RandomSignals(1024, 150, 2);
  return signals;
}

void Report(benchmark::State& state, double seconds, int lanes) {
  const double each = seconds / static_cast<double>(state.iterations());
  state.counters["kHz"] = 1e-3 / each;
  state.counters["ratio"] = each / ProductSeconds(lanes);
}

void RunEstimate(benchmark::State& state, const RandomNetwork& network) {
  const auto made = MakeForceNetwork(network.info, network.weights);
  const auto estimate = made->Windowed();
  const auto& signals = Signals();
  std::array<double, 4> outputs{};
  std::size_t t = 0;
  const double start = Now();
  for (auto _ : state) {
    estimate->Push(signals[t++ % signals.size()], outputs);
    benchmark::DoNotOptimize(outputs.data());
  }
  Report(state, Now() - start, network.weights.lstm.empty() ? 1 : kWindow);
  estimate->Reset();
  double error = 0;
  const std::span<const TactileSignals> samples(signals);
  for (std::size_t k = 0; k < 200; ++k) {
    if (!estimate->Push(samples[k], outputs)) continue;
    const auto window = static_cast<std::size_t>(network.info.window);
    const auto seen = samples.subspan(k + 1 - window, window);
    const auto expected = ReferenceOutputs(network.info, network.weights, seen);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      error = std::max(error, std::abs(outputs[i] - expected[i]));
    }
  }
  state.counters["error"] = error;
}

// Exactly the last 50 samples, for every sample.
void Windowed(benchmark::State& state) {
  RunEstimate(state, Network("rnn_21"));
}
void FeedForward(benchmark::State& state) {
  RunEstimate(state, Network("dnn_21"));
}

BENCHMARK(Windowed);
BENCHMARK(FeedForward);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
