#include "slave/tactile/fingertip.h"

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
  // A contact begins at half of |sigma| = 0.02 sqrt(3) and ends at a quarter.
  Press({0, 0, -0.016}, 20);
  EXPECT_FALSE(fingertip_.touch().touching);
  Press({0, 0, -0.019}, 20);
  EXPECT_TRUE(fingertip_.touch().touching);
  Press({0, 0, -0.010}, 20);
  EXPECT_TRUE(fingertip_.touch().touching);
  Press({0, 0, -0.008}, 20);
  EXPECT_FALSE(fingertip_.touch().touching);
}

TEST_F(FingertipTest, ASilentFingertipIsStaleThenLostAndItsWindowStartsAgain) {
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

// Up to two missing samples are interpolated, with a sigma that grows. The window is filled with
// the interpolated samples.
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

// The baseline follows a drift without contact. A press is not treated as drift.
TEST_F(FingertipTest, RestValuesAreFollowedWhileNothingIsNear) {
  Rest(10);
  const auto drifted = [](float counts, float pressure) {
    FingerReading reading = ReadingOf(kNothing, false);
    for (float& electrode : reading.channels) electrode += counts;
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

// Electrodes that saturate from the start at either end of the converter: no contact is detected,
// but none can be excluded.
TEST_F(FingertipTest, SaturatedElectrodesAreFlaggedWithoutAContactToo) {
  for (const float end : {0.0F, 4095.0F}) {
    const auto localiser = MakeLocaliser(Options(), SimulatedLayout(7e-3));
    CheckedFingertip fingertip(Options(), &network_, *localiser);
    FingerReading reading = ReadingOf(kNothing, false);
    reading.channels.fill(end);
    for (int i = 0; i < 10; ++i) fingertip.Estimate(reading, false);
    EXPECT_EQ(fingertip.touch().validity, Validity::kExtrapolated) << end;
    EXPECT_EQ(fingertip.touch().reason, "electrodes are saturated or dead");
    EXPECT_FALSE(fingertip.touch().touching);
  }
}

// The network's window has ten samples: nine more contain the flawed one.
TEST_F(FingertipTest, AForceStaysFlaggedUntilTheWindowHasLeftTheFlawedSample) {
  Rest(10);
  Press({0, 0, -0.9}, 10);
  FingerReading saturated = ReadingOf({0, 0, -0.9}, true);
  saturated.channels[4] = 4095;
  fingertip_.Estimate(saturated, false);
  for (int i = 1; i <= 9; ++i) {
    Press({0, 0, -0.9}, 1);
    EXPECT_EQ(fingertip_.touch().validity, Validity::kExtrapolated) << i;
    EXPECT_EQ(fingertip_.touch().reason, "a faulty sample in the window") << i;
  }
  Press({0, 0, -0.9}, 1);
  EXPECT_EQ(fingertip_.touch().validity, Validity::kValid);
}

// An electrode without change for 100 samples at 100 Hz has no noise, so it does not work.
TEST_F(FingertipTest, ConstantElectrodesAreFlaggedAtRestAndInContact) {
  for (const bool touches : {false, true}) {
    for (const std::size_t stuck : {std::size_t{0}, std::size_t{7}, kElectrodeCount * 1UL}) {
      fingertip_.Reset();
      const Vector3d force(0, 0, touches ? -0.3 : 0);
      for (int i = 0; i < 130; ++i) {
        FingerReading reading = ReadingOf(force, touches && i >= 5);
        for (std::size_t e = 0; e < kElectrodeCount; ++e) {
          if (stuck != kElectrodeCount && e != stuck) {
            reading.channels[e] += static_cast<float>(i % 2);
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

// Five samples without noise flag a driver that repeats its sample. Electrodes that never showed
// noise are flagged after the longest constant time in the training data.
TEST(StuckElectrodesTest, ASilencedNoiseIsAFrozenSample) {
  StuckElectrodes noisy(100, kElectrodeCount), quiet(100, kElectrodeCount);
  FingerReading reading, same;
  for (int k = 0; k < 50; ++k) {
    reading.channels.fill(static_cast<float>(k % 3));
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
