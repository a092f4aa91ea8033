#include "slave/pipeline/manipulator_agreement/encoder_registration.h"

#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

// A camera whose tip position has an offset and is `late` images late, and encoders with a scale
// error of 4 %.
class EncoderRegistrationTest : public testing::Test {
 protected:
  static constexpr double kStep = 1e-4, kSigma = 5e-6, kLag = 0.45;  // [m], [m], [periods]

  void Update(int image, int late, const Vector3d& error = Vector3d::Zero()) {
    const auto tip = [](int i) { return Vector3d(0, -kStep * i, 0); };
    const Vector3d noise(noise_(random_), noise_(random_), noise_(random_));
    const Vector3d p_S_seen = Vector3d(2e-3, 1e-3, 0) + tip(image - late) + noise + error;
    registration_.Update(p_S_seen, {1.04 * tip(image), kLag}, kSigma);
  }
  EncoderRegistration registration_;

 private:
  std::mt19937 random_{1};
  std::normal_distribution<> noise_{0, kSigma};
};

// Reference: chi-square with three degrees of freedom, whose mean is 3.
TEST_F(EncoderRegistrationTest, InnovationsAreWhitenedWhateverOffsetAndScale) {
  double sum = 0;
  for (int i = 0; i < 200; ++i) {
    Update(i, 0);
    sum += registration_.nis();
  }
  EXPECT_NEAR(sum / 200, 3, 0.5);
}

TEST_F(EncoderRegistrationTest, ImagesThatBecomeLateDeviateByOneStep) {
  for (int i = 0; i < 40; ++i) Update(i, 0);
  for (int i = 40; i < 60; ++i) {
    Update(i, 1);
    EXPECT_NEAR(registration_.deviation().y(), kStep, 0.25 * kStep) << i;
    EXPECT_GT(registration_.nis(), 21) << i;
  }
}

TEST_F(EncoderRegistrationTest, AJumpOfTheTipIsNotTakenIntoTheRegistration) {
  for (int i = 0; i < 40; ++i) Update(i, 0);
  for (int i = 40; i < 60; ++i) Update(i, 0, {1e-3, 0, 0});
  EXPECT_NEAR(registration_.innovation().x(), 1e-3, 3 * kSigma);
  Update(60, 0);
  EXPECT_LT(registration_.nis(), 21);
}

}  // namespace
}  // namespace palpate
