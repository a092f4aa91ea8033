#include "shared/state/slave_state.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

// Reference: design, validity: a force that cannot be known is unknown, which is not zero.
TEST(ValidityTest, OnlyWhatWasComputedIsKnown) {
  EXPECT_TRUE(IsForceKnown(Validity::kValid));
  EXPECT_TRUE(IsForceKnown(Validity::kExtrapolated));
  EXPECT_TRUE(IsForceKnown(Validity::kPunctured));
  EXPECT_FALSE(IsForceKnown(Validity::kStale));
  EXPECT_FALSE(IsForceKnown(Validity::kTrackingLost));
  EXPECT_FALSE(IsForceKnown(Validity::kFailed));
}

}  // namespace
}  // namespace palpate
