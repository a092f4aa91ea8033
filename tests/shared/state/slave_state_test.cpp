#include "shared/state/slave_state.h"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(EventsTest, HoldWhatWasAddedAndNothingElse) {
  Events events;
  EXPECT_TRUE(events.empty());
  events.Add(Event::kLimit);
  Events more;
  more.Add(Event::kCommandRefused);
  events.Add(more);
  EXPECT_TRUE(events.Has(Event::kLimit));
  EXPECT_TRUE(events.Has(Event::kCommandRefused));
  EXPECT_FALSE(events.Has(Event::kContact));
  events.Clear();
  EXPECT_TRUE(events.empty());
}

TEST(ValidityTest, TheWorseOfTwoCounts) {
  EXPECT_EQ(Worse(Validity::kValid, Validity::kStale), Validity::kStale);
  EXPECT_EQ(Worse(Validity::kFailed, Validity::kExtrapolated), Validity::kFailed);
}

// Reference: design, validity: a force that cannot be known is unknown, which is not zero.
TEST(ValidityTest, OnlyWhatWasComputedIsKnown) {
  EXPECT_TRUE(IsForceKnown(Validity::kValid));
  EXPECT_TRUE(IsForceKnown(Validity::kExtrapolated));
  EXPECT_TRUE(IsForceKnown(Validity::kPunctured));
  EXPECT_FALSE(IsForceKnown(Validity::kStale));
  EXPECT_FALSE(IsForceKnown(Validity::kTrackingLost));
  EXPECT_FALSE(IsForceKnown(Validity::kFailed));
}

TEST(LocalModelTest, PenetrationIsPositiveBeyondThePlaneAndNegativeOutside) {
  LocalModel model;
  model.reference = {0, 0.01, 0};
  model.normal = {0, 1, 0};
  EXPECT_DOUBLE_EQ(model.Penetration({5, 0.008, 0}), 0.002);
  EXPECT_DOUBLE_EQ(model.Penetration({5, 0.013, 0}), -0.003);
  EXPECT_FALSE(model.known());
}

}  // namespace
}  // namespace palpate
