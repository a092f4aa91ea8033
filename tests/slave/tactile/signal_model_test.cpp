#include "slave/tactile/signal_model.h"

#include <random>

#include <gtest/gtest.h>

#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Signals = SignalPattern::Signals;

constexpr double kSampleRate = 100;  // [Hz]

// Two kinds of contacts, each along another direction, with an accuracy of 1 % of the signals.
Signals Direction(int kind) {
  Signals u;
  for (int i = 0; i < kPatternSignals; ++i) u[i] = 1 + 0.8 * std::cos(0.7 * i + 2 * kind);
  return u.normalized();
}

SignalPattern TwoKinds() {
  SignalPattern pattern;
  for (int kind = 0; kind < 2; ++kind) {
    const Signals u = Direction(kind);
    SignalPattern::Covariance shape = u * u.transpose();
    shape.diagonal().array() += 1e-4;
    pattern.kinds.push_back({0.5, shape});
  }
  pattern.force.setConstant(0.001);
  return pattern;
}

class SignalModelTest : public ::testing::Test {
 protected:
  // A contact whose signals have the length `size` [counts], with noise of 0.9 counts rms.
  TactileSignals Contact(int kind, double size) {
    TactileSignals change{};
    const Signals u = size * Direction(kind);
    for (std::size_t i = 0; i < kElectrodeCount; ++i) {
      change[i] = u[static_cast<Eigen::Index>(i)] + noise_(random_);
    }
    change[kElectrodeCount + 1] = u[kElectrodeCount] + noise_(random_);
    return change;
  }
  void Update(const TactileSignals& change) { model_.Update(change, dead_, still_, 0); }

  SignalModel model_{TwoKinds(), kSampleRate};
  Electrodes dead_{}, still_{};
  std::mt19937 random_{3};
  std::normal_distribution<double> noise_{0, 0.9};
};

TEST_F(SignalModelTest, SignalsThatChangeTogetherAreUnchanged) {
  double mahalanobis2 = 0, pressure2 = 0;
  for (int i = 0; i < 300; ++i) {
    const TactileSignals change = Contact(i / 150, 100);
    Update(change);
    for (std::size_t e = 0; e < kElectrodeCount; ++e) {
      ASSERT_NEAR(model_.corrected()[e], change[e], 1) << i << " E" << e + 1;
    }
    EXPECT_EQ(model_.replaced(), 0);
    mahalanobis2 += model_.mahalanobis2() / 300;
    pressure2 += model_.pressure_residual() * model_.pressure_residual() / 300;
  }
  EXPECT_LT(mahalanobis2, 1.2);
  EXPECT_LT(pressure2, 1.5);
}

// Reference: the direction of the contact; 1 % of 100 counts and the others' noise.
TEST_F(SignalModelTest, AnElectrodeThatDeviatesIsReplacedByTheOthers) {
  for (std::size_t wrong = 0; wrong < kElectrodeCount; ++wrong) {
    model_.Reset();
    for (int i = 0; i < 20; ++i) {
      TactileSignals change = Contact(1, 100);
      change[wrong] = -40;
      Update(change);
    }
    EXPECT_TRUE(model_.is_replaced(wrong));
    EXPECT_EQ(model_.replaced(), 1);
    EXPECT_NEAR(model_.corrected()[wrong], 100 * Direction(1)[static_cast<Eigen::Index>(wrong)], 4);
    EXPECT_GT(model_.force_sigma(), 0);
  }
}

TEST_F(SignalModelTest, TheCommonDriftOfAllElectrodesIsRemoved) {
  for (int i = 0; i < 300; ++i) {
    TactileSignals change = Contact(0, 100);
    for (std::size_t e = 0; e < kElectrodeCount; ++e) change[e] += 10;
    Update(change);
  }
  EXPECT_NEAR(model_.drift(), 10, 1);
  double left = 0;
  for (std::size_t e = 0; e < kElectrodeCount; ++e) {
    left += (model_.corrected()[e] - 100 * Direction(0)[static_cast<Eigen::Index>(e)]) /
            kElectrodeCount;
  }
  EXPECT_NEAR(left, 0, 1);
}

TEST_F(SignalModelTest, APressureThatIsNotThatOfTheElectrodesDisagrees) {
  for (int i = 0; i < 100; ++i) {
    TactileSignals change = Contact(1, 100);
    change[kElectrodeCount + 1] += 30;
    Update(change);
  }
  EXPECT_GT(std::abs(model_.pressure_residual()), 5);
}

// With three times the usual noise, the filtered values have less noise than the readings.
TEST_F(SignalModelTest, ExcessNoiseIsSubtracted) {
  noise_ = std::normal_distribution<double>(0, 2.7);
  double read = 0, used = 0;
  for (int i = 0; i < 400; ++i) {
    const TactileSignals change = Contact(0, 100);
    Update(change);
    if (i < 200) continue;
    for (std::size_t e = 0; e < kElectrodeCount; ++e) {
      const double truth = 100 * Direction(0)[static_cast<Eigen::Index>(e)];
      read += (change[e] - truth) * (change[e] - truth);
      used += (model_.corrected()[e] - truth) * (model_.corrected()[e] - truth);
    }
  }
  EXPECT_LT(used, 0.5 * read);
}

// Noise is amplified as signals are: a gain of 0.7 shows before anything touches.
TEST_F(SignalModelTest, UnusualNoiseShowsTheGain) {
  for (int i = 0; i < 200; ++i) Update(Contact(0, 0));
  EXPECT_NEAR(model_.noise().relative(), 1, 0.1);
  EXPECT_LT(model_.noise().gain_sigma(), 0.05);
  for (const double gain : {0.7, 1.3}) {
    model_.Reset();
    for (int i = 0; i < 200; ++i) {
      TactileSignals change = Contact(0, 0);
      for (double& x : change) x *= gain;
      Update(change);
    }
    EXPECT_NEAR(model_.noise().relative(), gain, 0.1 * gain);
    EXPECT_GT(3 * model_.noise().gain_sigma(), std::abs(gain - 1));
  }
}

TEST_F(SignalModelTest, NoSampleAllocates) {
  const TactileSignals change = Contact(0, 100);
  const long before = AllocationCount();
  for (int i = 0; i < 1000; ++i) Update(change);
  EXPECT_EQ(AllocationCount() - before, 0);
}

TEST_F(SignalModelTest, AnElectrodeThatJumpsAloneIsReplacedUntilItIsBack) {
  for (int i = 0; i < 50; ++i) Update(Contact(0, 100));
  TactileSignals jumped = Contact(0, 100);
  jumped[2] += 15;
  Update(jumped);
  EXPECT_TRUE(model_.is_replaced(2));
  Update(Contact(0, 100));
  EXPECT_FALSE(model_.is_replaced(2));
}

TEST_F(SignalModelTest, AConstantElectrodeNeedsLessToBeWrong) {
  const auto off = [&] {
    TactileSignals change = Contact(0, 100);
    change[2] = 100 * Direction(0)[2] - 5;
    return change;
  };
  Update(off());
  EXPECT_FALSE(model_.is_replaced(2));
  still_[2] = true;
  Update(off());
  EXPECT_TRUE(model_.is_replaced(2));
}

}  // namespace
}  // namespace palpate
