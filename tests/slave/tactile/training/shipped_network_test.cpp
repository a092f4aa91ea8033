#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "slave/site/fingertips/simulated_fingertip.h"
#include "slave/site/fingertips/simulated_presses.h"
#include "slave/tactile/network/force_network.h"
#include "slave/tactile/signals/rest_values.h"
#include "slave/tactile/training/estimate_errors.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

const std::filesystem::path kShipped = SourcePath("/deploy/fingertips/simulated-tnn21");

// Starts and contacts that it was not trained on, of the fingertip as it is now. The paper's
// figures for rnn_21 are 0.3018, 0.1854, 0.0569; this holds a third of the strictest.
TEST(ShippedNetworkTest, FeelsTheSimulatedFingertip) {
  SimulatedPresses options;
  options.presses = 60;
  options.seed = 987654;
  const auto recordings = SimulatePresses(options);
  std::vector<Stretch> all;
  for (std::size_t i = 0; i < recordings.size(); ++i) all.push_back({i, 0, recordings[i].end, 0});
  const auto network = LoadForceNetwork(kShipped);
  const std::vector<Window> windows = WindowsOf(all, network->info().window);
  const ForceErrors errors = CompareForces(EstimateForces(*network, recordings, windows),
                                           MeasuredForces(recordings, windows));
  EXPECT_LT(errors.smse.maxCoeff(), 0.019) << errors.smse.transpose();
  // What it says of its own error is true; presses differ from set to set.
  EXPECT_LT((errors.rmse.array() / network->info().sigma.array()).maxCoeff(), 1.5);
}

// A pad that lies along a block of foam touches wider than a sphere at the same force: learnt from
// spheres alone it told a quarter too little, with a small sigma. What contacts are off by as a
// rule is a tenth.
TEST(ShippedNetworkTest, FeelsGentleContactsThatAreWiderThanSpheres) {
  constexpr double kPeriod = 0.01;  // [s]
  constexpr std::size_t kTouches = 60, kSettled = 120, kAll = 250;
  const auto network = LoadForceNetwork(kShipped);
  for (const double radius : {6e-3, 8e-3, 9.5e-3, 11e-3}) {
    FingertipLoad load;
    load.p_F = {0, 0, -7e-3};
    load.f_F = {-0.064, -0.004, 0.178};
    load.radius = radius;
    SimulatedFingertip fingertip(11);
    RestValues rest(50);
    std::vector<FingerReading> readings;
    LabelledRecording recording;
    for (std::size_t i = 0; i < kAll; ++i) {
      readings.push_back(fingertip.Sample(i < kTouches ? nullptr : &load, kPeriod));
      rest.Take(readings.back());
      recording.t.push_back(kPeriod * static_cast<double>(i));
      recording.force.push_back(-load.f_F.cast<float>());
    }
    for (const FingerReading& reading : readings) recording.change.push_back(rest.Change(reading));
    recording.end = recording.t.size();
    const std::vector<Stretch> all{{0, 0, recording.end, 0}};
    const auto windows = WindowsOf(all, network->info().window);
    const auto told = EstimateForces(*network, {&recording, 1}, windows);
    double mean = 0, count = 0;
    for (std::size_t i = 0; i < windows.size(); ++i) {
      if (windows[i].last < kSettled) continue;
      mean += static_cast<double>(told[i].norm());
      count += 1;
    }
    const double size = load.f_F.norm();
    EXPECT_NEAR(mean / count / load.f_F.norm(), 1, 3 * network->info().error.At(size) / size)
        << 1e3 * radius << " mm";
  }
}

TEST(ShippedNetworkTest, IsSmallAndSaysWhatMadeIt) {
  EXPECT_LT(std::filesystem::file_size(kShipped / "network.json"), 400'000U);
  const auto network = LoadForceNetwork(kShipped);
  EXPECT_EQ(network->info().architecture, "tnn_21");
  EXPECT_NE(network->info().origin.find("palpate-slave train simulated"), std::string::npos);
  EXPECT_GT(network->info().learnt_force, 4.5);
}

}  // namespace
}  // namespace palpate
