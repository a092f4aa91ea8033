#include <cmath>

#include <gtest/gtest.h>

#include "shared/wire/state_message.h"

namespace palpate {
namespace {

constexpr Time kSensed{std::chrono::seconds(1'700'000'000)};

TEST(TraceMessageTest, StagesComeBackToTheMicrosecond) {
  const SampleTrace sent{7, kSensed, kSensed + Seconds(0.002), kSensed + Seconds(0.008),
                         kSensed + Seconds(0.009)};
  v1::SampleTrace message;
  ToProto(sent, &message);
  std::string reason;
  const auto came = FromProto(message, &reason);
  ASSERT_TRUE(came) << reason;
  EXPECT_EQ(came->sample, 7U);
  EXPECT_EQ(came->sensed_at, kSensed) << "states are found by it";
  EXPECT_NEAR(SecondsBetween(kSensed, came->acquired_at), 0.002, 1e-6);
  EXPECT_NEAR(SecondsBetween(kSensed, came->processed_at), 0.008, 1e-6);
  EXPECT_NEAR(SecondsBetween(kSensed, came->solved_at), 0.009, 1e-6);
}

TEST(TraceMessageTest, WhatIsNoTraceIsRefused) {
  std::string reason;
  v1::SampleTrace message;
  EXPECT_FALSE(FromProto(message, &reason));
  EXPECT_NE(reason.find("sensed_at"), std::string::npos);
  ToProto(SampleTrace{1, kSensed, kSensed, kSensed, kSensed}, &message);
  ASSERT_TRUE(FromProto(message, &reason));
  for (const float value : {-1.F, NAN, INFINITY, 1e30F}) {
    message.set_processed(value);
    EXPECT_FALSE(FromProto(message, &reason)) << value;
  }
}

}  // namespace
}  // namespace palpate
