#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "slave/service/messages.h"

namespace palpate {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

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

TEST(RequestsTest, QualityIsZeroForEightyOrTenToOneHundred) {
  v1::WatchImagesRequest request;
  EXPECT_EQ(QualityOf(request), 80);
  for (const unsigned quality : {10U, 100U}) {
    request.set_quality(quality);
    EXPECT_EQ(QualityOf(request), static_cast<int>(quality));
  }
  for (const unsigned quality : {1U, 9U, 101U, 4'000'000'000U}) {
    request.set_quality(quality);
    EXPECT_THROW(QualityOf(request), std::invalid_argument) << quality;
  }
}

TEST(RequestsTest, WhatIsAbsentStaysAsItIs) {
  const ParameterChange change = ToChange(v1::SetParametersRequest{});
  EXPECT_FALSE(change.position_scale || change.force_scale || change.force_limit ||
               change.young_modulus);
}

TEST(RequestsTest, ParametersKeepTheirValues) {
  v1::SetParametersRequest request;
  request.set_position_scale(0.5);
  request.set_force_scale(2);
  request.set_force_limit(100);
  request.set_young_modulus(1e13);
  const ParameterChange change = ToChange(request);
  EXPECT_EQ(change.position_scale, 0.5);
  EXPECT_EQ(change.force_scale, 2);
  EXPECT_EQ(change.force_limit, 100);
  EXPECT_EQ(change.young_modulus, 1e13);
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
