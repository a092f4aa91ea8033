#include "slave/live/planned_depth.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

// A scene whose planned depth is 5 mm.
class PlannedDepthTest : public testing::Test {
 protected:
  // Contact of three samples, the second one at `depth` [m]. Returns the alarm at its end.
  std::string Press(double depth, Validity validity = Validity::kValid) {
    ContactEstimate estimate;
    estimate.validity = validity;
    if (IsForceKnown(validity)) estimate.force = Eigen::Vector3d::UnitY();
    for (const double part : {0.5, 1.0, 0.5}) {
      estimate.depth = part * depth;
      EXPECT_THAT(planned_.Update(estimate, true), IsEmpty()) << "the contact has not ended";
    }
    return planned_.Update({}, false);
  }

  PlannedDepth planned_{5e-3};
};

TEST_F(PlannedDepthTest, AContactMoreThanATenthDeeperIsReportedWhenItEnds) {
  EXPECT_THAT(Press(5.4e-3), IsEmpty());
  EXPECT_THAT(Press(8e-3), AllOf(HasSubstr("8 mm"), HasSubstr("operator.press.depth is 5 mm"),
                                 HasSubstr("run `study`")));
  EXPECT_THAT(planned_.Update({}, false), IsEmpty()) << "once";
}

TEST_F(PlannedDepthTest, OnlyAStillDeeperContactIsReportedAgain) {
  EXPECT_THAT(Press(8e-3), HasSubstr("8 mm"));
  EXPECT_THAT(Press(7.9e-3), IsEmpty());
  EXPECT_THAT(Press(9e-3), HasSubstr("9 mm"));
}

TEST_F(PlannedDepthTest, ADepthWithoutAForceDoesNotCount) {
  EXPECT_THAT(Press(8e-3, Validity::kTrackingLost), IsEmpty());
}

}  // namespace
}  // namespace palpate
