#include "slave/checks/fingertips/fingertip_checks.h"

#include <gtest/gtest.h>

#include "tests/slave/tactile/fakes.h"

namespace palpate {
namespace {

constexpr int kWindow = 15;  // samples

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
  Consistency consistency_{kWindow};
};

// The limits are those of CHECKS.md.
TEST_F(FingertipChecksTest, AForceFarFromThatOfTheModelIsFlagged) {
  const auto lasting = [&](double ratio, double sigma) {
    consistency_.Reset();
    FingertipSample sample{tip_, &consistency_};
    sample.force_ratio = ratio;
    sample.force_ratio_sigma = sigma;
    FailedCheck code = FailedCheck::kNone;
    for (int i = 0; i < kWindow; ++i) code = CodeOf(sample);
    return code;
  };
  for (const double ratio : {0.67, 1.5}) EXPECT_EQ(lasting(ratio, 0), FailedCheck::kNone) << ratio;
  for (const double ratio : {0.6, 1.7}) {
    EXPECT_EQ(lasting(ratio, 0), FailedCheck::kTransfer) << ratio;
    EXPECT_EQ(lasting(ratio, 0.5), FailedCheck::kNone) << ratio << " within its sigma";
  }
}

// As long as a network may look back.
TEST_F(FingertipChecksTest, AFingertipBesideItsEncoderPoseIsFlaggedAtOnceAndForAWindow) {
  FingertipSample sample{tip_, &consistency_};
  sample.encoder_error = 0;
  for (int i = 0; i < kWindow; ++i) EXPECT_EQ(CodeOf(sample), FailedCheck::kNone);
  sample.encoder_error = 0.55e-3;
  EXPECT_EQ(CodeOf(sample), FailedCheck::kArm);
  sample.encoder_error = 0;
  for (int i = 1; i < kWindow; ++i) EXPECT_EQ(CodeOf(sample), FailedCheck::kArm) << i;
  EXPECT_EQ(CodeOf(sample), FailedCheck::kNone);
}

}  // namespace
}  // namespace palpate
