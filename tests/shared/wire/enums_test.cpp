#include <gtest/gtest.h>

#include "shared/wire/enum_names.h"
#include "shared/wire/fields.h"

namespace palpate {
namespace {

// Reference: the names. The two sides order the values differently, so none may be cast.
TEST(EnumsTest, EveryValidityKeepsItsName) {
  const auto wire_name = [](Validity v) { return v1::Validity_Name(ToProto(v)); };
  EXPECT_EQ(wire_name(Validity::kValid), "VALIDITY_VALID");
  EXPECT_EQ(wire_name(Validity::kExtrapolated), "VALIDITY_EXTRAPOLATED");
  EXPECT_EQ(wire_name(Validity::kPunctured), "VALIDITY_PUNCTURED");
  EXPECT_EQ(wire_name(Validity::kStale), "VALIDITY_STALE");
  EXPECT_EQ(wire_name(Validity::kTrackingLost), "VALIDITY_TRACKING_LOST");
  EXPECT_EQ(wire_name(Validity::kFailed), "VALIDITY_FAILED");
}

TEST(EnumsTest, EveryEventKeepsItsName) {
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kContact)), "EVENT_CONTACT");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kRelease)), "EVENT_RELEASE");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kPuncture)), "EVENT_PUNCTURE");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kTrackingLost)), "EVENT_TRACKING_LOST");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kTrackingRegained)), "EVENT_TRACKING_REGAINED");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kLimit)), "EVENT_LIMIT");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kHold)), "EVENT_HOLD");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kModelChanged)), "EVENT_MODEL_CHANGED");
  EXPECT_EQ(v1::Event_Name(ToProto(Event::kCommandRefused)), "EVENT_COMMAND_REFUSED");
}

// Tables and CSV files use one name for a value.
TEST(EnumsTest, EveryNameIsThatOfTheProtocol) {
  for (int i = 1; i < v1::Validity_descriptor()->value_count(); ++i) {
    const auto& value = *v1::Validity_descriptor()->value(i);
    EXPECT_EQ(ProtoNameOf(value), ToString(FromProto(static_cast<v1::Validity>(value.number()))));
  }
  for (int i = 1; i < v1::FailedCheck_descriptor()->value_count(); ++i) {
    const auto& value = *v1::FailedCheck_descriptor()->value(i);
    EXPECT_EQ(ProtoNameOf(value),
              ToString(FromProto(static_cast<v1::FailedCheck>(value.number()))));
  }
}

}  // namespace
}  // namespace palpate
