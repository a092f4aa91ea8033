#include <gtest/gtest.h>

#include "slave/checks/fingertips/fingertip_checks.h"

namespace palpate {
namespace {

// A model whose force is 1 N. The limits are those of CHECKS.md.
TEST(ContactChecksTest, AForceFarFromThatOfTheModelIsFlagged) {
  Checks<ContactSample> checks = MakeContactChecks();
  const auto check = [&](double depth, double force, double sigma = 0) {
    return checks.Examine({.press = ContactSample::Press{depth, force, sigma, 1, 1}}).verdict.check;
  };
  for (const double force : {0.66, 1.49}) EXPECT_EQ(check(1, force), FailedCheck::kNone) << force;
  for (const double force : {0.64, 1.51}) {
    EXPECT_EQ(check(1, force), FailedCheck::kTransfer) << force;
    EXPECT_EQ(check(1, force, 0.1), FailedCheck::kNone) << force << " within its sigma";
    EXPECT_EQ(check(0.5, force), FailedCheck::kNone) << force << " shallow";
  }
  for (const double force : {0.34, 1.81}) EXPECT_EQ(check(0.5, force), FailedCheck::kTransfer);
}

// As long as a network may look back.
TEST(ContactChecksTest, AFingertipBesideTheArmIsFlaggedForAWhileAndWidensSigma) {
  Checks<ContactSample> checks = MakeContactChecks();
  const auto examine = [&](bool agrees) {
    return checks.Examine({.agrees_with_encoders = agrees, .apart = 0.2});
  };
  EXPECT_EQ(examine(true).verdict.validity, Validity::kValid);
  EXPECT_EQ(examine(true).sigma_force, 0.2);
  EXPECT_EQ(examine(false).verdict.check, FailedCheck::kArm);
  int flagged = 1;
  while (examine(true).verdict.check == FailedCheck::kArm) ++flagged;
  EXPECT_EQ(flagged, 15);
  EXPECT_EQ(checks.Examine({.apart = 0.2}).sigma_force, 0) << "not compared";
}

}  // namespace
}  // namespace palpate
