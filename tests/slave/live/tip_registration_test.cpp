#include <gtest/gtest.h>

#include "slave/live/operator_port.h"

namespace palpate {
namespace {

using Eigen::Vector3d;

TEST(TipRegistrationTest, AToolAtRestGivesTheDifferenceOfImageAndEncoders) {
  TipRegistration registration(1e-5);
  const Vector3d encoders(0.04, 0.09, 0), off(0.0003, -0.0001, 0);
  for (int image = 0; image < 3; ++image) registration.Add(encoders + off, encoders);
  EXPECT_LT((registration.offset() - off).norm(), 1e-15);
}

TEST(TipRegistrationTest, AMovingToolTeachesNothing) {
  TipRegistration registration(1e-5);
  for (int image = 0; image < 50; ++image) {
    const Vector3d encoders(0, 1e-3 * image, 0);
    registration.Add(encoders - Vector3d(0, 5e-4, 0), encoders);  // the image lags behind
  }
  EXPECT_EQ(registration.offset(), Vector3d::Zero());
}

// Alternating noise of +-e averages out to below e / 32 once the filter's memory is full.
TEST(TipRegistrationTest, NoiseAveragesOut) {
  TipRegistration registration(1e-5);
  const double e = 1e-5;
  for (int image = 0; image < 400; ++image) {
    registration.Add(Vector3d(image % 2 != 0 ? e : -e, 0, 0), Vector3d::Zero());
  }
  EXPECT_LT(registration.offset().norm(), e / 31);
}

}  // namespace
}  // namespace palpate
