#include "slave/checks/fingertips/fingertip_checks.h"

#include <gtest/gtest.h>

#include "tests/slave/tactile/fakes.h"

namespace palpate {
namespace {

constexpr int kCheckWindow = 15;  // samples

class FingertipChecksTest : public ::testing::Test {
 protected:
  FailedCheck CodeOf(const FingertipSample& sample) {
    Findings findings = checks_.Examine(sample);
    findings.verdict.Add(consistency_.Close().verdict);
    return findings.verdict.check;
  }

  testing_fakes::PadLocaliser localiser_;
  Fingertip tip_{Tactile{}, nullptr, localiser_};
  Checks<FingertipSample> checks_ = MakeFingertipChecks();
  Consistency consistency_{kCheckWindow};
};

// The limits are those of CHECKS.md.
TEST_F(FingertipChecksTest, AForceFarFromThatOfTheModelIsFlagged) {
  const auto lasting = [&](double ratio, double sigma) {
    consistency_.Reset();
    FingertipSample sample{tip_, &consistency_};
    sample.force_ratio = ratio;
    sample.force_ratio_sigma = sigma;
    FailedCheck code = FailedCheck::kNone;
    for (int i = 0; i < kCheckWindow; ++i) code = CodeOf(sample);
    return code;
  };
  for (const double ratio : {0.67, 1.5}) EXPECT_EQ(lasting(ratio, 0), FailedCheck::kNone) << ratio;
  for (const double ratio : {0.6, 1.7}) {
    EXPECT_EQ(lasting(ratio, 0), FailedCheck::kTransfer) << ratio;
    EXPECT_EQ(lasting(ratio, 0.5), FailedCheck::kNone) << ratio << " within its sigma";
  }
}

// The longest window that a network may have.
TEST_F(FingertipChecksTest, AFingertipBesideItsEncoderPoseIsFlaggedAtOnceAndForAWindow) {
  FingertipSample sample{tip_, &consistency_};
  sample.encoder_error = 0;
  for (int i = 0; i < kCheckWindow; ++i) EXPECT_EQ(CodeOf(sample), FailedCheck::kNone);
  sample.encoder_error = 0.55e-3;
  EXPECT_EQ(CodeOf(sample), FailedCheck::kArm);
  sample.encoder_error = 0;
  for (int i = 1; i < kCheckWindow; ++i) EXPECT_EQ(CodeOf(sample), FailedCheck::kArm) << i;
  EXPECT_EQ(CodeOf(sample), FailedCheck::kNone);
}

// The fingertip was pressed with 2 N while the baseline was taken. Once the contact is gone, the
// estimated force pulls and is flagged. A contact that adheres for a moment while it opens is
// flagged only during that moment.
TEST_F(FingertipChecksTest, APullingForceShowsThatTheBaselineWasMeasuredInContact) {
  Tactile tactile;
  tactile.channels = {4, "kPa"};
  tactile.rest_samples = 10;
  testing_fakes::MeanNetwork network(1);
  network.BeOfChannels(4);
  const auto check_after = [&](double pull, int samples) {
    checks_.Reset();
    Fingertip tip(tactile, &network, localiser_);
    const auto take = [&](double force, int count) {
      FailedCheck code = FailedCheck::kNone;
      FingerReading reading;
      reading.present = true;
      reading.channels.resize(4);
      reading.channels.fill(100);
      reading.channels[2] += static_cast<float>(force / testing_fakes::MeanNetwork::kPerCount);
      reading.channels[3] += force != 0 ? 50 : 0;  // so that PadLocaliser finds a contact
      for (int i = 0; i < count; ++i) {
        tip.Estimate(reading, false, false);
        code = CodeOf({tip, &consistency_});
      }
      return code;
    };
    EXPECT_EQ(take(0, 30), FailedCheck::kNone);
    EXPECT_EQ(take(-2, 100), FailedCheck::kNone) << "a press";
    EXPECT_EQ(take(pull, samples), FailedCheck::kRestDrift);
    return take(-2, 10);
  };
  EXPECT_EQ(check_after(0.5, 20), FailedCheck::kNone);
  EXPECT_EQ(check_after(2, 60), FailedCheck::kRestDrift) << "until the next baseline";
}

}  // namespace
}  // namespace palpate
