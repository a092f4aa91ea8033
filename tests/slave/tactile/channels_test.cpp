// Sensors without electrodes: any number of channels of any unit.
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "slave/tactile/channel_signals.h"
#include "slave/tactile/fingertip.h"
#include "slave/tactile/localise/localiser.h"
#include "slave/tactile/network/network_weights.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

constexpr double kChannelNoise = 0.01;  // of a channel [kPa]

// fz = -0.5 of channel 1, 0.25 of the last one squared and 0.1 of the second times the size.
std::unique_ptr<ForceNetwork> QuadraticNetwork(int channels) {
  NetworkInfo info;
  info.architecture = "qnn_" + std::to_string(channels);
  info.inputs = channels;
  info.channels = {channels, "kPa"};
  info.outputs = 3;
  info.noise = kChannelNoise;
  info.sigma.setConstant(0.01);
  NetworkWeights weights;
  weights.LeaveUnscaled(channels, 3);
  weights.input_scale.setConstant(2);
  DenseLayer layer{WeightMatrix::Zero(3 * channels, 3), Eigen::VectorXf::Zero(3)};
  layer.kernel(0, 2) = -0.5F;
  layer.kernel(channels + 1 % channels, 2) = 0.1F;
  layer.kernel(3 * channels - 1, 2) = 0.25F;
  weights.dense.push_back(layer);
  return MakeForceNetwork(info, weights);
}

double ExpectedForce(const std::vector<double>& change) {
  double mean2 = 0.01;
  const auto n = static_cast<double>(change.size());
  for (const double x : change) mean2 += x * x / 4 / n;
  return -0.5 * change[0] / 2 + 0.1 * change[1 % change.size()] / 2 * std::sqrt(mean2) +
         0.25 * change.back() * change.back() / 4;
}

Tactile ChannelOptions(int channels) {
  Tactile tactile;
  tactile.fingers.emplace_back();
  tactile.channels = {channels, "kPa"};
  tactile.rest_samples = 50;
  return tactile;
}

class ChannelSensorTest : public ::testing::TestWithParam<int> {
 protected:
  FingerReading Reading(const std::vector<double>& change) {
    FingerReading reading;
    reading.present = true;
    reading.channels.resize(change.size());
    for (std::size_t i = 0; i < change.size(); ++i) {
      reading.channels[i] = static_cast<float>(7 + change[i] + kChannelNoise * noise_(random_));
    }
    return reading;
  }

  std::size_t count_ = static_cast<std::size_t>(GetParam());
  Tactile tactile_ = ChannelOptions(GetParam());
  std::unique_ptr<ForceNetwork> network_ = QuadraticNetwork(GetParam());
  ElectrodeLayout layout_{GetParam()};
  std::unique_ptr<Localiser> localiser_ = MakeChannelLocaliser(kChannelNoise, layout_);
  Fingertip fingertip_{tactile_, network_.get(), *localiser_};
  std::mt19937 random_{3};
  std::normal_distribution<double> noise_{0, 1};
};

// Reference: the formula of FORMAT.md. Tolerance: the noise of the sample and of the baseline.
TEST_P(ChannelSensorTest, GivesTheForceOfItsNetworkWithoutAllocation) {
  std::vector<double> change(count_, 0.0);
  for (int i = 0; i < 50; ++i) fingertip_.Estimate(Reading(change), false);
  for (std::size_t i = 0; i < count_; ++i) change[i] = 1 + 0.01 * static_cast<double>(i);
  const FingerReading pressed = Reading(change);
  const long before = OwnAllocationCount();
  const FingerTouch& touch = fingertip_.Estimate(pressed, false);
  EXPECT_EQ(OwnAllocationCount(), before);
  ASSERT_TRUE(touch.force_F);
  EXPECT_NEAR(touch.force_F->z(), ExpectedForce(change),
              0.02 + 0.02 * std::abs(ExpectedForce(change)));
  EXPECT_EQ(touch.validity, Validity::kValid);
}

TEST_P(ChannelSensorTest, ASampleOfAnotherCountHasNoForce) {
  for (int i = 0; i < 60; ++i) fingertip_.Estimate(Reading(std::vector(count_, 0.0)), false);
  EXPECT_TRUE(fingertip_.touch().force_F);
  fingertip_.Estimate(Reading(std::vector(count_ == 1 ? 2 : count_ - 1, 0.0)), false);
  EXPECT_FALSE(fingertip_.touch().force_F);
  EXPECT_EQ(fingertip_.touch().check, FailedCheck::kElectrode);
}

// A driver that repeats its samples, with a network file that does not state the longest constant
// time.
TEST_P(ChannelSensorTest, AFrozenDriverIsFlaggedWithoutAKey) {
  FingerReading reading;
  for (int i = 0; i < 60; ++i) {
    reading = Reading(std::vector(count_, 0.0));
    fingertip_.Estimate(reading, false);
  }
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
  for (int i = 0; i < 20; ++i) fingertip_.Estimate(reading, false);
  EXPECT_TRUE(fingertip_.stuck().are_frozen());
  fingertip_.Estimate(Reading(std::vector(count_, 0.0)), false);
  EXPECT_FALSE(fingertip_.stuck().are_frozen());
}

INSTANTIATE_TEST_SUITE_P(Counts, ChannelSensorTest, ::testing::Values(1, 2, 16, 19, 60, 256));

// With noise below the resolution a channel may be constant for any time.
TEST(StuckElectrodesTest, ChannelsOfACoarseResolutionAreNotFrozen) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0.3, 0.3);
  StuckElectrodes stuck(0, 4, false);
  FingerReading reading;
  reading.channels.resize(4);
  for (int k = 0; k < 5000; ++k) {
    for (float& x : reading.channels) x = static_cast<float>(std::round(noise(random)));
    stuck.Take(reading, k < 50);
    EXPECT_FALSE(stuck.are_frozen() || stuck.are_repeated()) << k;
  }
  for (int k = 0; k < 1000; ++k) stuck.Take(reading);
  EXPECT_FALSE(stuck.are_frozen());
}

std::shared_ptr<const ChannelPattern> PairPattern() {
  ChannelPattern pattern;
  pattern.expectation = Eigen::Matrix2d{{0, 1}, {1, 0}};
  pattern.tolerance = Eigen::Vector2d::Constant(0.1);
  pattern.relative_tolerance = Eigen::Vector2d::Constant(0.2);
  pattern.below = Eigen::Vector2d::Constant(0.2);
  pattern.above = Eigen::Vector2d::Constant(10);
  pattern.second_difference = Eigen::Vector2d::Constant(0.3);
  return std::make_shared<const ChannelPattern>(pattern);
}

TactileSignals Pair(double first, double second) {
  TactileSignals change;
  change.resize(4);
  change[0] = first, change[1] = second;
  return change;
}

TEST(ChannelSignalsTest, AChannelThatJumpsIsFaultyUntilItIsBack) {
  ChannelSignals signals(PairPattern());
  for (int k = 0; k < 10; ++k) signals.Update(Pair(5, 5));
  EXPECT_EQ(signals.fault(), "");
  for (int k = 0; k < 10; ++k) signals.Update(Pair(5.5, 5));  // within the relative tolerance
  EXPECT_NE(signals.fault(), "");
  signals.Update(Pair(5, 5));
  EXPECT_EQ(signals.fault(), "");
}

TEST(ChannelSignalsTest, AContactThatBeginsFastIsNoJump) {
  ChannelSignals signals(PairPattern());
  for (int k = 0; k < 10; ++k) signals.Update(Pair(0, 0));
  for (int k = 1; k < 10; ++k) {
    signals.Update(Pair(0.5 * k, 0.5 * k));
    if (k > 1) EXPECT_EQ(signals.fault(), "") << k;
  }
}

TEST(ChannelSignalsTest, TheOppositeSideOfContactsIsNoContact) {
  ChannelSignals signals(PairPattern());
  signals.Update(Pair(-0.5, -0.5));
  EXPECT_TRUE(signals.is_opposite() && !signals.is_beyond());
  signals.Update(Pair(11, 11));
  EXPECT_TRUE(signals.is_beyond() && !signals.is_opposite());
  ChannelSignals others(PairPattern());
  others.Update(Pair(9, 5));
  EXPECT_EQ(others.fault(), "the channels do not match each other");
}

// Two channels at x = 1 and 3 cm, the second of which changes three times as much, downwards.
TEST(ChannelLocaliserTest, TheContactIsTheMeanOfTheChannelsByTheirChange) {
  ElectrodeLayout layout(3);
  layout.p_F = {{0.01, 0, 0}, {0.03, 0, 0}, {0, 0.5, 0}};
  layout.n_F = {-Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitY()};
  const auto localiser = MakeChannelLocaliser(kChannelNoise, layout);
  TactileSignals change;
  change.resize(5);
  EXPECT_EQ(localiser->Locate(change, {}).status, TouchPlace::Status::kNoContact);
  change[0] = 1, change[1] = -3, change[2] = 4 * kChannelNoise;
  const TouchPlace place = localiser->Locate(change, {});
  EXPECT_EQ(place.status, TouchPlace::Status::kFound);
  EXPECT_EQ(place.active, 2);
  EXPECT_NEAR(place.p_F.x(), 0.025, 1e-12);
  EXPECT_NEAR(place.n_F.z(), -1, 1e-12);
}

}  // namespace
}  // namespace palpate
