#include <algorithm>
#include <array>
#include <limits>
#include <memory>
#include <thread>
#include <utility>

#include <gtest/gtest.h>

#include "tests/slave/tactile/network/reference_network.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Outputs = std::array<double, 4>;
using Samples = std::span<const TactileSignals>;

// The largest difference from the reference over all full windows, the reference evaluated from
// the state of zero for each.
double WorstWindow(const RandomNetwork& network, Samples samples) {
  const auto estimate = MakeForceNetwork(network.info, network.weights)->Windowed();
  const auto window = static_cast<std::size_t>(network.info.window);
  double worst = 0;
  for (std::size_t t = 0; t < samples.size(); ++t) {
    Outputs outputs{};
    const bool full = estimate->Push(samples[t], outputs);
    EXPECT_EQ(full, t + 1 >= window) << "sample " << t;
    if (!full) continue;
    const auto expected =
        ReferenceOutputs(network.info, network.weights, samples.subspan(t + 1 - window, window));
    for (std::size_t k = 0; k < outputs.size(); ++k) {
      worst = std::max(worst, std::abs(outputs[k] - expected[k]));
    }
  }
  return worst;
}

// Reference: the formulas, unit by unit, from a zero state. Numbers of units and window lengths
// need not fill vector registers. Tolerance: both in double precision, exponentials within some
// units of the last place, sums over up to 53 units in another order, outputs of order 1.
TEST(LstmNetworkTest, AnyShapeIsTheReference) {
  for (const char* architecture : {"rnn_21", "rnn_19"}) {
    for (const auto& [units, window] :
         {std::pair{1, 64}, {3, 7}, {15, 2}, {20, 50}, {32, 1}, {32, 64}}) {
      RandomNetwork network = MakeRandomNetwork(architecture, units, 0.3f, 5);
      network.info.window = window;
      EXPECT_LT(WorstWindow(network, RandomSignals(window + 20, 150, 6)), 1e-12)
          << architecture << ", " << units << " units, window " << window;
    }
  }
}

// A window with a bad sample would give wrong forces without a flag, so the window is restarted.
TEST(LstmNetworkTest, SamplesThatAreNotFiniteRestartTheWindow) {
  const RandomNetwork network = MakeRandomNetwork("rnn_19", 20, 0.3f, 13);
  const auto made = MakeForceNetwork(network.info, network.weights);
  const auto samples = RandomSignals(130, 150, 14);
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    const auto estimate = made->Windowed();
    const auto fresh = made->Windowed();
    Outputs outputs{}, expected{};
    for (std::size_t t = 0; t < 70; ++t) estimate->Push(samples[t], outputs);
    TactileSignals broken = samples[70];
    broken[18] = bad;
    EXPECT_FALSE(estimate->Push(broken, outputs));
    for (std::size_t t = 71; t < 130; ++t) {
      const bool full = estimate->Push(samples[t], outputs);
      ASSERT_EQ(full, t >= 71 + 49);
      ASSERT_EQ(fresh->Push(samples[t], expected), full);
      if (full) {
        ASSERT_EQ(outputs, expected) << "as if it began here";
      }
    }
    estimate->Reset();
    EXPECT_FALSE(estimate->Push(samples[0], outputs));
  }
}

TEST(LstmNetworkTest, PushingAllocatesNothing) {
  const RandomNetwork network = MakeRandomNetwork("rnn_21", 20, 0.3f, 19);
  const auto made = MakeForceNetwork(network.info, network.weights);
  const auto windowed = made->Windowed();
  auto samples = RandomSignals(300, 150, 20);
  samples[200][3] = std::numeric_limits<float>::quiet_NaN();
  Outputs outputs{};
  const long before = AllocationCount();
  for (const auto& sample : samples) windowed->Push(sample, outputs);
  windowed->Reset();
  EXPECT_EQ(AllocationCount(), before);
}

// Estimators share constant data: five fingers in five threads give the same result as one, and
// estimators may outlive the network object.
TEST(LstmNetworkTest, EstimatesOfOneNetworkAreIndependent) {
  const RandomNetwork network = MakeRandomNetwork("rnn_21", 20, 0.3f, 21);
  auto made = MakeForceNetwork(network.info, network.weights);
  std::vector<std::unique_ptr<ForceEstimate>> estimates;
  for (int k = 0; k < 5; ++k) estimates.push_back(made->Windowed());
  made.reset();
  const auto samples = RandomSignals(200, 150, 22);
  std::array<Outputs, 5> last{};
  {
    std::vector<std::jthread> threads;
    for (std::size_t k = 0; k < 5; ++k) {
      threads.emplace_back([&, k] {
        for (const auto& sample : samples) estimates[k]->Push(sample, last[k]);
      });
    }
  }
  for (const Outputs& outputs : last) EXPECT_EQ(outputs, last[0]);
  EXPECT_NE(last[0], Outputs{});
}

}  // namespace
}  // namespace palpate
