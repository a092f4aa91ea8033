#include <array>
#include <filesystem>
#include <vector>

#include <gtest/gtest.h>

#include "slave/simulator/fingertips/simulated_fingertip.h"
#include "slave/simulator/presses/simulated_presses.h"
#include "slave/tactile/network/force_network.h"
#include "tests/slave/tactile/rest_values.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

const std::filesystem::path kShippedNetwork = SourcePath("/deploy/fingertips/simulated-tnn21");

constexpr int kRestSamples = 50;

// Forces that the network estimates from `readings` [N], from the sample on that fills its window.
std::vector<Eigen::Vector3d> EstimateAll(const ForceNetwork& network,
                                         const std::vector<FingerReading>& readings) {
  RestValues rest(kRestSamples);
  for (const FingerReading& reading : readings) rest.Take(reading);
  const auto estimate = network.Windowed();
  std::vector<Eigen::Vector3d> forces;
  std::array<double, 3> outputs{};
  for (const FingerReading& reading : readings) {
    if (!estimate->Push(rest.Change(reading), outputs)) continue;
    forces.emplace_back(outputs[0], outputs[1], outputs[2]);
  }
  return forces;
}

// The presses are not in its training set; the simulated fingertip is the present one. The paper's
// normalised errors of rnn_21 are 0.3018, 0.1854, 0.0569; the limit here is a third of the
// smallest.
TEST(ShippedNetworkTest, EstimatesForcesOfTheSimulatedFingertip) {
  const SimulatedPresses presses{.presses = 60, .rest_samples = kRestSamples, .seed = 987654};
  const auto network = LoadForceNetwork(kShippedNetwork);
  Eigen::Array3d error2(0, 0, 0), force2(0, 0, 0), force(0, 0, 0);
  double count = 0;
  for (int k = 0; k < CountStarts(presses); ++k) {
    const SimulatedStart start = SimulateStart(presses, k);
    const auto forces = EstimateAll(*network, start.readings);
    const std::size_t before = start.force.size() - forces.size();
    for (std::size_t i = 0; i < forces.size(); ++i) {
      const Eigen::Vector3d& truth = start.force[before + i];
      error2 += (forces[i] - truth).array().square();
      force2 += truth.array().square();
      force += truth.array();
      count += 1;
    }
  }
  const Eigen::Array3d variance = force2 / count - (force / count).square();
  EXPECT_LT((error2 / count / variance).maxCoeff(), 0.019);
  // The error that it states is right; presses differ from set to set.
  EXPECT_LT(((error2 / count).sqrt() / network->info().sigma.array()).maxCoeff(), 1.5);
}

// A pad that lies along a block of foam touches a wider area than a sphere at the same force. A
// network that was trained on spheres alone estimated a quarter too little, with a small sigma. The
// tolerance is three sigma, typically 10 %.
TEST(ShippedNetworkTest, EstimatesGentleContactsThatAreWiderThanSpheres) {
  constexpr double kPeriod = 0.01;  // [s]
  constexpr std::size_t kTouches = 60, kSettled = 120, kAll = 250;
  const auto network = LoadForceNetwork(kShippedNetwork);
  for (const double radius : {6e-3, 8e-3, 9.5e-3, 11e-3}) {
    FingertipLoad load;
    load.p_F = {0, 0, -7e-3};
    load.f_F = {-0.064, -0.004, 0.178};
    load.radius = radius;
    SimulatedFingertip fingertip(11);
    std::vector<FingerReading> readings;
    for (std::size_t i = 0; i < kAll; ++i) {
      readings.push_back(fingertip.Sample(i < kTouches ? nullptr : &load, kPeriod));
    }
    const auto forces = EstimateAll(*network, readings);
    const std::size_t settled = kSettled - (kAll - forces.size());
    double mean = 0;
    for (std::size_t i = settled; i < forces.size(); ++i) mean += forces[i].norm();
    mean /= static_cast<double>(forces.size() - settled);
    const double size = load.f_F.norm();
    EXPECT_NEAR(mean / size, 1, 3 * network->info().error.At(size) / size) << 1e3 * radius << " mm";
  }
}

}  // namespace
}  // namespace palpate
