#include "slave/tactile/fingertip.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "slave/checks/fingertips/fingertip_checks.h"
#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/localise/localiser.h"
#include "tests/slave/tactile/fakes.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using namespace testing_fakes;

// A fingertip with the checks of its signals, as a pipeline adds them.
class CheckedFingertip : public Fingertip {
 public:
  using Fingertip::Fingertip;
  const FingerTouch& Estimate(const FingerReading& reading, bool after_gap, bool is_clear = false) {
    touch_ = Fingertip::Estimate(reading, after_gap, is_clear);
    touch_.Add(checks_.Examine({*this, &consistency_}).verdict);
    touch_.Add(consistency_.Close().verdict);
    return touch_;
  }
  [[nodiscard]] const FingerTouch& touch() const { return touch_; }

 private:
  Checks<FingertipSample> checks_ = MakeFingertipChecks();
  Consistency consistency_;
  FingerTouch touch_;
};

const Vector3d kNothing(0, 0, 0);

// Rest values from the first five samples, a network that looks back over ten, 100 Hz.
class FingertipTest : public ::testing::Test {
 protected:
  static Tactile Options() {
    Tactile tactile;
    tactile.rest_samples = 5;
    return tactile;
  }
  const FingerTouch& Estimate(const Vector3d& force_F, bool active, bool after_gap = false) {
    return fingertip_.Estimate(ReadingOf(force_F, active), after_gap);
  }
  void Rest(int samples) {
    for (int i = 0; i < samples; ++i) Estimate(kNothing, false);
  }
  void Press(const Vector3d& force_F, int samples) {
    for (int i = 0; i < samples; ++i) Estimate(force_F, true);
  }

  MeanNetwork network_{10, 0.02, 1.0};
  PadLocaliser localiser_;
  CheckedFingertip fingertip_{Options(), &network_, localiser_};
};

TEST_F(FingertipTest, TheForceIsUnknownUntilTheWindowOfRestSamplesAndOthersIsFull) {
  for (int i = 1; i <= 9; ++i) {
    const FingerTouch& touch = Estimate(kNothing, false);
    EXPECT_FALSE(touch.force_F.has_value()) << i;
    EXPECT_EQ(touch.validity, Validity::kTrackingLost) << i;
    EXPECT_FALSE(touch.reason.empty()) << i;
  }
  // The tenth sample fills the window: those from which the rest values came count.
  const FingerTouch& touch = Estimate(kNothing, false);
  ASSERT_TRUE(touch.force_F.has_value());
  EXPECT_EQ(touch.validity, Validity::kValid);
  EXPECT_NEAR(touch.force_F->norm(), 0, 1e-12);
}

TEST_F(FingertipTest, RestValuesThatTakeLongerThanTheWindowLeaveItFull) {
  Tactile tactile = Options();
  tactile.rest_samples = 25;
  CheckedFingertip fingertip(tactile, &network_, localiser_);
  for (int i = 0; i < 24; ++i) {
    EXPECT_FALSE(fingertip.Estimate(ReadingOf(kNothing, false), false).force_F.has_value());
  }
  EXPECT_TRUE(fingertip.Estimate(ReadingOf(kNothing, false), false).force_F.has_value());
}

TEST_F(FingertipTest, APressIsFeltWithItsPlaceAndLetGo) {
  Rest(10);
  const Vector3d force(0.1, -0.05, -0.4);
  Press(force, 10);
  const FingerTouch& touch = fingertip_.touch();
  EXPECT_TRUE(touch.touching);
  ASSERT_TRUE(touch.force_F.has_value());
  EXPECT_NEAR((*touch.force_F - force).norm(), 0, 1e-6);
  EXPECT_NEAR((touch.place.p_F - Vector3d(0, 0, -7e-3)).norm(), 0, 1e-12);
  EXPECT_NEAR(touch.sigma, 0.02, 1e-12);
  Rest(11);
  EXPECT_FALSE(fingertip_.touch().touching);
}

// Paper B, V: soft contacts drop out for a few samples; here for two of five.
TEST_F(FingertipTest, AnIntermittentContactDoesNotFlicker) {
  Rest(10);
  Press({0, 0, -0.4}, 10);
  for (int i = 0; i < 50; ++i) {
    EXPECT_TRUE(Estimate({0, 0, -0.4}, i % 5 > 1).touching) << i;
    EXPECT_TRUE(fingertip_.touch().place.usable()) << i;
  }
}

TEST_F(FingertipTest, AForceWithinTheNetworksErrorIsNoTouch) {
  Rest(10);
  // Half of |sigma| = 0.02 sqrt(3) begins a touch, a quarter ends it.
  Press({0, 0, -0.016}, 20);
  EXPECT_FALSE(fingertip_.touch().touching);
  Press({0, 0, -0.019}, 20);
  EXPECT_TRUE(fingertip_.touch().touching);
  Press({0, 0, -0.010}, 20);
  EXPECT_TRUE(fingertip_.touch().touching);
  Press({0, 0, -0.008}, 20);
  EXPECT_FALSE(fingertip_.touch().touching);
}

TEST_F(FingertipTest, AfterAGapTheWindowStartsAnewAndRestValuesStay) {
  Rest(30);
  EXPECT_FALSE(Estimate(kNothing, false, true).force_F.has_value());
  EXPECT_EQ(fingertip_.touch().validity, Validity::kTrackingLost);
  Press({0, 0, -0.4}, 9);
  ASSERT_TRUE(fingertip_.touch().force_F.has_value());
  EXPECT_NEAR(fingertip_.touch().force_F->z(), -0.4 * 9 / 10, 1e-6);
}

TEST_F(FingertipTest, ASilentFingertipIsStaleThenLostAndStartsItsWindowAnew) {
  Rest(10);
  Press({0, 0, -0.4}, 10);
  const FingerReading missing;
  for (int i = 0; i < 5; ++i) fingertip_.Estimate(missing, false);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kStale);
  EXPECT_TRUE(fingertip_.touch().force_F.has_value());  // the last numbers
  fingertip_.Estimate(missing, false);                  // 60 ms
  EXPECT_EQ(fingertip_.touch().validity, Validity::kTrackingLost);
  EXPECT_FALSE(fingertip_.touch().force_F.has_value());
  EXPECT_FALSE(fingertip_.touch().touching);
  Rest(9);
  EXPECT_FALSE(fingertip_.touch().force_F.has_value());
  Rest(1);
  EXPECT_TRUE(fingertip_.touch().force_F.has_value());
}

// Up to two are taken for granted, with a sigma that grows; the window is filled as if they had
// come.
TEST_F(FingertipTest, AFewMissingSamplesAreMadeUpFor) {
  Rest(10);
  Press({0, 0, -0.4}, 10);
  for (const int missing : {1, 2, 5}) {
    for (int i = 0; i < missing; ++i) fingertip_.Estimate(FingerReading{}, false);
    EXPECT_EQ(fingertip_.touch().validity, missing > 2 ? Validity::kStale : Validity::kValid);
    ASSERT_TRUE(Estimate({0, 0, -0.4}, true).force_F.has_value()) << missing;
    EXPECT_NEAR(fingertip_.touch().force_F->z(), -0.4, 1e-6);
    EXPECT_EQ(fingertip_.touch().validity, Validity::kValid) << missing;
  }
}

// A hand that has just set out may go on as fast as in the last sample.
TEST_F(FingertipTest, AMissingSampleAfterASuddenOneMayBeAsFarFromIt) {
  Rest(10);
  Press({0, 0, -0.2}, 50);
  Estimate({0, 0, -0.6}, true);  // a mean over ten: 0.04 N at once
  fingertip_.Estimate(FingerReading{}, false);
  EXPECT_GT(fingertip_.touch().sigma, 0.04);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
}

// What drifts while nothing is near is rest; what presses is not, even there.
TEST_F(FingertipTest, RestValuesAreFollowedWhileNothingIsNear) {
  Rest(10);
  const auto drifted = [](float counts, float pressure) {
    FingerReading reading = ReadingOf(kNothing, false);
    for (float& electrode : reading.electrodes) electrode += counts;
    reading.pdc += pressure;
    return reading;
  };
  for (int i = 0; i < 200; ++i) fingertip_.Estimate(drifted(10, 0), false, true);
  EXPECT_NEAR(fingertip_.touch().force_F->norm(), 0, 0.01);
  for (int i = 0; i < 200; ++i) fingertip_.Estimate(drifted(40, 30), false, true);
  EXPECT_GT(fingertip_.touch().force_F->norm(), 0.2);
}

TEST_F(FingertipTest, CountsThatAreNotFiniteAreFlaggedAndForgotten) {
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Rest(20);
    FingerReading reading = ReadingOf(kNothing, true);
    reading.pdc = bad;
    const FingerTouch& touch = fingertip_.Estimate(reading, false);
    EXPECT_EQ(touch.validity, Validity::kTrackingLost);
    EXPECT_FALSE(touch.force_F.has_value());
    EXPECT_FALSE(touch.touching);
    Rest(9);
    EXPECT_FALSE(fingertip_.touch().force_F.has_value());
    Rest(1);
    ASSERT_TRUE(fingertip_.touch().force_F.has_value());
    EXPECT_NEAR(fingertip_.touch().force_F->norm(), 0, 1e-9);
  }
}

TEST_F(FingertipTest, NotFiniteCountsAreNoRestValues) {
  FingerReading bad = ReadingOf(kNothing, false);
  bad.electrodes[7] = std::numeric_limits<float>::quiet_NaN();
  for (int i = 0; i < 20; ++i) fingertip_.Estimate(bad, false);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kTrackingLost);
  Rest(10);
  ASSERT_TRUE(fingertip_.touch().force_F.has_value());
  EXPECT_NEAR(fingertip_.touch().force_F->norm(), 0, 1e-9);
}

TEST_F(FingertipTest, WhatIsBeyondTheLearntOrOfSaturatedElectrodesIsExtrapolated) {
  Rest(10);
  Press({0, 0, -1.01}, 10);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kExtrapolated);
  EXPECT_GT(fingertip_.touch().sigma, 0.02);
  Press({0, 0, -0.9}, 10);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
  FingerReading saturated = ReadingOf({0, 0, -0.9}, true);
  saturated.electrodes[4] = 4095;
  EXPECT_EQ(fingertip_.Estimate(saturated, false).validity, Validity::kExtrapolated);
  EXPECT_TRUE(fingertip_.touch().touching);
}

// A network whose gain was fitted knows the error of fz alone: [0, 0, 0.03].
TEST_F(FingertipTest, ComponentsOfUnknownErrorAreAsWrongAsTheWorstKnown) {
  network_.SetSigma({0, 0, 0.03});
  CheckedFingertip fingertip(Options(), &network_, localiser_);
  for (int i = 0; i < 10; ++i) fingertip.Estimate(ReadingOf(kNothing, false), false);
  for (const Vector3d& force : {Vector3d(0.3, 0, 0), Vector3d(0.2, -0.2, -0.1)}) {
    for (int i = 0; i < 10; ++i) fingertip.Estimate(ReadingOf(force, true), false);
    EXPECT_NEAR(fingertip.touch().sigma, 0.03, 1e-9);
  }
}

// Reference: the largest of 0.5 % of the force, a quarter of what it changes by in a sample,
// evenly, and half of what it changes by otherwise.
TEST_F(FingertipTest, AForceThatLeapsIsLessSureThanOneThatGoesOnAsItDid) {
  constexpr double kStep = 0.01, kLeaps = 0.2, kShare = 0.005;  // [N], [N], [-]
  MeanNetwork prompt(1, 0.02, 1.0);
  prompt.SetError({.relative = kShare});
  CheckedFingertip fingertip(Options(), &prompt, localiser_);
  double force = 0;
  const auto sigma_after = [&](double change) {
    force += change;
    fingertip.Estimate(ReadingOf({0, 0, -force}, true), false);
    return fingertip.touch().sigma;
  };
  for (int i = 0; i < 10; ++i) fingertip.Estimate(ReadingOf(kNothing, false), false);
  double sigma = 0;
  for (int i = 0; i < 40; ++i) sigma = sigma_after(kStep);
  EXPECT_NEAR(sigma, std::max(kShare * force, kStep / 4), 1e-5);
  EXPECT_GT(kStep / 4, kShare * force);
  EXPECT_GT(sigma_after(kLeaps), (kLeaps - kStep) / 2);
  for (int i = 0; i < 40; ++i) sigma = sigma_after(0);
  EXPECT_NEAR(sigma, kShare * force, 1e-5);
  EXPECT_GT(sigma_after(-kLeaps), kLeaps / 2);
}

// Silent from the start at either end of the converter: nothing seems to touch, which is not known.
TEST_F(FingertipTest, SaturatedElectrodesAreFlaggedWithoutAContactToo) {
  for (const float end : {0.0F, 4095.0F}) {
    for (const char* variant : {"auto", "paper"}) {
      Tactile tactile = Options();
      tactile.localise = variant;
      const auto localiser = MakeLocaliser(tactile, SimulatedLayout(7e-3));
      CheckedFingertip fingertip(tactile, &network_, *localiser);
      FingerReading reading = ReadingOf(kNothing, false);
      reading.electrodes.fill(end);
      for (int i = 0; i < 10; ++i) fingertip.Estimate(reading, false);
      EXPECT_EQ(fingertip.touch().validity, Validity::kExtrapolated) << variant << " " << end;
      EXPECT_EQ(fingertip.touch().reason, "electrodes are saturated or dead");
      EXPECT_FALSE(fingertip.touch().touching);
    }
  }
}

// The network looks back over ten samples: nine more hold the flawed one.
TEST_F(FingertipTest, AForceStaysFlaggedUntilTheWindowHasLeftTheFlawedSample) {
  Rest(10);
  Press({0, 0, -0.9}, 10);
  FingerReading saturated = ReadingOf({0, 0, -0.9}, true);
  saturated.electrodes[4] = 4095;
  fingertip_.Estimate(saturated, false);
  for (int i = 1; i <= 9; ++i) {
    Press({0, 0, -0.9}, 1);
    EXPECT_EQ(fingertip_.touch().validity, Validity::kExtrapolated) << i;
    EXPECT_EQ(fingertip_.touch().reason, "a faulty sample in the window") << i;
  }
  Press({0, 0, -0.9}, 1);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
}

// What stands still for 100 samples at 100 Hz has no noise: it is no electrode that works.
TEST_F(FingertipTest, ElectrodesThatStandStillAreFlaggedAtRestAndTouching) {
  for (const bool touches : {false, true}) {
    for (const std::size_t stuck : {std::size_t{0}, std::size_t{7}, kElectrodeCount * 1UL}) {
      fingertip_.Reset();
      const Vector3d force(0, 0, touches ? -0.3 : 0);
      for (int i = 0; i < 130; ++i) {
        FingerReading reading = ReadingOf(force, touches && i >= 5);
        for (std::size_t e = 0; e < kElectrodeCount; ++e) {
          if (stuck != kElectrodeCount && e != stuck) {
            reading.electrodes[e] += static_cast<float>(i % 2);
          }
        }
        const FingerTouch& touch = fingertip_.Estimate(reading, false);
        const bool is_late = i >= 105;
        if (i >= 20 && (i < 99 || is_late)) {
          EXPECT_EQ(touch.validity, is_late ? Validity::kExtrapolated : Validity::kValid)
              << i << " " << stuck << " " << touch.reason;
        }
      }
      EXPECT_NE(fingertip_.touch().reason.find("constant"), std::string_view::npos);
    }
  }
}

TEST_F(FingertipTest, AForceWithoutAnActiveElectrodeIsFlagged) {
  Rest(10);
  for (int i = 0; i < 10; ++i) Estimate({0, 0, -0.5}, false);
  EXPECT_FALSE(fingertip_.touch().touching);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kExtrapolated);
}

TEST_F(FingertipTest, WithoutANetworkTheElectrodesDecideAndTheForceIsUnknown) {
  CheckedFingertip fingertip(Options(), nullptr, localiser_);
  for (int i = 0; i < 6; ++i) fingertip.Estimate(ReadingOf(kNothing, false), false);
  const FingerTouch& touch = fingertip.Estimate(ReadingOf(kNothing, true), false);
  EXPECT_TRUE(touch.touching);
  EXPECT_FALSE(touch.force_F.has_value());
  EXPECT_EQ(touch.validity, Validity::kFailed);
}

TEST_F(FingertipTest, NoSampleAllocates) {
  const FingerReading missing;
  FingerReading bad = ReadingOf(kNothing, true);
  bad.pac = std::numeric_limits<float>::quiet_NaN();
  const FingerReading reading = ReadingOf({0, 0, -0.3}, true);
  const long before = AllocationCount();
  for (int i = 0; i < 10'000; ++i) {
    fingertip_.Estimate(i % 97 == 0 ? missing : i % 89 == 0 ? bad : reading, i % 83 == 0);
  }
  EXPECT_EQ(AllocationCount() - before, 0);
}

// A driver that repeats itself is known within five samples by a noise that went silent; electrodes
// without noise say nothing before their patience is over.
TEST(StuckElectrodesTest, ASilencedNoiseIsAFrozenSample) {
  StuckElectrodes noisy(100), quiet(100);
  FingerReading reading, same;
  for (int k = 0; k < 50; ++k) {
    reading.electrodes.fill(static_cast<float>(k % 3));
    noisy.Take(reading);
    quiet.Take(same);
  }
  for (int k = 0; k < 3; ++k) noisy.Take(reading);
  EXPECT_FALSE(noisy.are_frozen()) << "as may happen";
  for (int k = 0; k < 40; ++k) noisy.Take(reading);
  EXPECT_TRUE(noisy.are_frozen());
  EXPECT_FALSE(quiet.are_frozen());
  noisy.Take(same);
  EXPECT_FALSE(noisy.are_frozen());
}

// A driver that sends every sample twice: the second one is none.
TEST_F(FingertipTest, ASampleThatIsTheLastOneAgainIsMissing) {
  const auto noisy = [](double force, int k) {
    FingerReading reading = ReadingOf({0, 0, force}, true);
    for (std::size_t e = 5; e < kElectrodeCount; ++e) {
      reading.electrodes[e] += static_cast<float>((k * 7 + static_cast<int>(e)) % 3);
    }
    return reading;
  };
  for (int k = 0; k < 40; ++k) fingertip_.Estimate(noisy(-0.2, k), false);
  fingertip_.Estimate(noisy(-0.3, 41), false);
  const double force = fingertip_.touch().force_F->z(), sigma = fingertip_.touch().sigma;
  fingertip_.Estimate(noisy(-0.3, 41), false);
  EXPECT_EQ(fingertip_.touch().force_F->z(), force);
  EXPECT_GT(fingertip_.touch().sigma, sigma);
  fingertip_.Estimate(noisy(-0.3, 42), false);
  EXPECT_LT(fingertip_.touch().force_F->z(), force);
}

TEST_F(FingertipTest, APressureBelowItsRestIsARestThatWasTakenInContact) {
  FingerReading pressed = ReadingOf({0, 0, 0}, false), free = pressed;
  pressed.pdc += 30;
  for (int k = 0; k < 20; ++k) fingertip_.Estimate(pressed, false);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
  for (int k = 0; k < 5; ++k) fingertip_.Estimate(free, false);
  EXPECT_EQ(fingertip_.touch().check, FailedCheck::kRestDrift);
  fingertip_.Reset();
  for (int k = 0; k < 20; ++k) fingertip_.Estimate(free, false);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
}

}  // namespace
}  // namespace palpate
