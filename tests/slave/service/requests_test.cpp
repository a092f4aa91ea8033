#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/service/messages.h"
#include "tests/support/not_finite.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

// Reference: the comments of teleoperation.proto.
TEST(RequestsTest, BulkRatesAreZeroForThirtyOrOneToOneHundredAndTwenty) {
  v1::WatchMeshRequest mesh;
  EXPECT_EQ(GapOf(mesh), Seconds(1 / 30.0));
  mesh.set_max_rate(120);
  EXPECT_EQ(GapOf(mesh), Seconds(1 / 120.0));
  v1::WatchImagesRequest video;
  for (const double rate : {0.99, 121.0, -1.0, kNan, kInf}) {
    mesh.set_max_rate(rate);
    video.set_max_rate(rate);
    EXPECT_THROW(GapOf(mesh), std::invalid_argument) << rate;
    EXPECT_THROW(GapOf(video), std::invalid_argument) << rate;
  }
}

TEST(RequestsTest, RatesOfStatesAreZeroForAllOrOneToOneThousand) {
  v1::WatchStateRequest states;
  EXPECT_EQ(GapOf(states), Clock::duration::zero());
  states.set_max_rate(1000);
  EXPECT_EQ(GapOf(states), Seconds(1e-3));
  for (const double rate : {0.5, -1.0, 1001.0, kNan, kInf}) {
    states.set_max_rate(rate);
    EXPECT_THAT(Thrown<std::invalid_argument>([&] { GapOf(states); }),
                testing::EndsWith("expected 0, or 1 to 1000"))
        << rate;
  }
}

TEST(RequestsTest, ImpossibleParametersAreRefused) {
  for (const double value : {0.0, -1.0, 5e-324, kNan, kInf, 1e20}) {
    v1::SetParametersRequest scale, force, limit, modulus;
    scale.set_position_scale(value);
    force.set_force_scale(value);
    limit.set_force_limit(value);
    modulus.set_young_modulus(value);
    for (const auto& request : {scale, force, limit, modulus}) {
      EXPECT_THROW(ToChange(request), std::invalid_argument) << request.ShortDebugString();
    }
  }
}

}  // namespace
}  // namespace palpate
