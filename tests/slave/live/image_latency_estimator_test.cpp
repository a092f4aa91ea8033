// Pictures that wait in a driver's queue while an arm presses to and fro.
#include "slave/live/image_latency_estimator.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Eigen::Vector3d;

constexpr double kRate = 60, kStiffness = 400, kDepth = 5e-3;  // [Hz], [N/m], [m]
constexpr double kSeenSigma = 2e-5;                            // one sigma of a place [m]
constexpr double kPeak = kStiffness * kDepth;

// What the arm does: up to 16 mm/s.
double DepthAt(double t) {
  return 0.5 * kDepth * (1 - std::cos(2 * std::numbers::pi * t));
}

struct Outcome {
  int valid = 0, wrong = 0, doubted = 0;
  double sigma = 0;  // the largest of the valid ones, once it has moved to and fro [N]
};

// Ten seconds of it, `late` by as much at each moment [s]; `scale`: of the arm's steps; for a
// second from `away_at` on no picture comes [s].
Outcome Press(const std::function<double(double)>& late, double scale = 1, double away_at = 100) {
  ImageLatencyEstimator pictures;
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, kSeenSigma);
  Outcome told;
  for (int k = 0; k < 10 * kRate; ++k) {
    const double t = k / kRate;
    if (t > away_at && t < away_at + 1) continue;
    const double depth = DepthAt(t - late(t)) + noise(random);
    ContactEstimate felt;
    felt.sensed_at = Time{} + Seconds(1 + t);
    felt.validity = Validity::kValid;
    felt.force = Vector3d(0, 0, kStiffness * depth);
    felt.sigma = kStiffness * kSeenSigma;
    felt.depth = std::max(0.0, depth);
    felt.p_S_tip = Vector3d(0.1, 0, -depth);
    felt.local_model.normal = Vector3d::UnitZ();
    felt.local_model.stiffness = kStiffness * Vector3d::UnitZ() * Vector3d::UnitZ().transpose();
    felt.local_model.revision = 1;
    felt.local_model.valid_radius = 1;
    pictures.Update(felt.p_S_tip, {7, 0, -scale * DepthAt(t)}, kSeenSigma, &felt);
    if (felt.validity != Validity::kValid) {
      ++told.doubted;
      continue;
    }
    const double error = std::abs(felt.force->z() - kStiffness * DepthAt(t));
    ++told.valid;
    told.wrong += error > 0.05 * kPeak && error > 3 * felt.sigma;
    if (t > 2) told.sigma = std::max(told.sigma, felt.sigma);
  }
  return told;
}

TEST(ImageLatencyEstimatorTest, ThoseThatAreInTimeAreAsSureAsBefore) {
  const Outcome told = Press([](double) { return 0.0; });
  EXPECT_EQ(told.doubted, 0);
  EXPECT_EQ(told.wrong, 0);
  EXPECT_LT(told.sigma, 3 * kStiffness * kSeenSigma);
}

// As a camera's that are stamped when they come.
TEST(ImageLatencyEstimatorTest, ALittleLateMakesAChangingForceLessSure) {
  const Outcome told = Press([](double) { return 0.05; });
  EXPECT_EQ(told.wrong, 0);
  EXPECT_EQ(told.doubted, 0);
  EXPECT_GT(told.sigma, 0.1 * kPeak);
}

TEST(ImageLatencyEstimatorTest, AQueueIsDoubtedFromItsFirstPicture) {
  const Outcome told = Press([](double t) { return t < 3.3 ? 0.0 : 0.2; });
  EXPECT_EQ(told.wrong, 0);
  EXPECT_GT(told.valid, 3 * kRate);
  EXPECT_GT(told.doubted, 6 * kRate);
}

TEST(ImageLatencyEstimatorTest, ADriverThatComesBackInTimeIsBelieved) {
  const Outcome told = Press([](double t) { return t > 2 && t < 5 ? 0.2 : 0.0; }, 1, 5);
  EXPECT_EQ(told.wrong, 0);
  EXPECT_GT(told.valid, 5.9 * kRate);
}

// One picture again and again, with noise of its own, while the arm presses on by 2 mm, stands
// there for two seconds and comes back: its force is that of where it stood.
TEST(ImageLatencyEstimatorTest, APictureThatStaysIsDoubtedAsLongAsTheArmIsElsewhere) {
  const double stays = 3.25;  // at half the depth
  const Outcome told = Press([&](double t) { return t > stays && t < 3.9 ? t - stays : 0.0; });
  EXPECT_EQ(told.wrong, 0);
  EXPECT_GT(told.doubted, 0.4 * kRate);
}

}  // namespace
}  // namespace palpate
