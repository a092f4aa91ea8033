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
  Outcome outcome;
  for (int k = 0; k < 10 * kRate; ++k) {
    const double t = k / kRate;
    if (t > away_at && t < away_at + 1) continue;
    const double depth = DepthAt(t - late(t)) + noise(random);
    ContactEstimate estimate;
    estimate.sensed_at = Time{} + Seconds(1 + t);
    estimate.validity = Validity::kValid;
    estimate.force = Vector3d(0, 0, kStiffness * depth);
    estimate.sigma = kStiffness * kSeenSigma;
    estimate.depth = std::max(0.0, depth);
    estimate.p_S_tip = Vector3d(0.1, 0, -depth);
    estimate.local_model.normal = Vector3d::UnitZ();
    estimate.local_model.stiffness = kStiffness * Vector3d::UnitZ() * Vector3d::UnitZ().transpose();
    estimate.local_model.revision = 1;
    estimate.local_model.valid_radius = 1;
    pictures.Update(estimate.p_S_tip, {7, 0, -scale * DepthAt(t)}, kSeenSigma, &estimate);
    if (estimate.validity != Validity::kValid) {
      ++outcome.doubted;
      continue;
    }
    const double error = std::abs(estimate.force->z() - kStiffness * DepthAt(t));
    ++outcome.valid;
    outcome.wrong += error > 0.05 * kPeak && error > 3 * estimate.sigma;
    if (t > 2) outcome.sigma = std::max(outcome.sigma, estimate.sigma);
  }
  return outcome;
}

TEST(ImageLatencyEstimatorTest, ThoseThatAreInTimeAreAsSureAsBefore) {
  const Outcome outcome = Press([](double) { return 0.0; });
  EXPECT_EQ(outcome.doubted, 0);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_LT(outcome.sigma, 3 * kStiffness * kSeenSigma);
}

// As a camera's that are stamped when they come.
TEST(ImageLatencyEstimatorTest, ALittleLateMakesAChangingForceLessSure) {
  const Outcome outcome = Press([](double) { return 0.05; });
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_EQ(outcome.doubted, 0);
  EXPECT_GT(outcome.sigma, 0.1 * kPeak);
}

TEST(ImageLatencyEstimatorTest, AQueueIsDoubtedFromItsFirstPicture) {
  const Outcome outcome = Press([](double t) { return t < 3.3 ? 0.0 : 0.2; });
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GT(outcome.valid, 3 * kRate);
  EXPECT_GT(outcome.doubted, 6 * kRate);
}

TEST(ImageLatencyEstimatorTest, ADriverThatComesBackInTimeIsBelieved) {
  const Outcome outcome = Press([](double t) { return t > 2 && t < 5 ? 0.2 : 0.0; }, 1, 5);
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GT(outcome.valid, 5.9 * kRate);
}

// One picture again and again, with noise of its own, while the arm presses on by 2 mm, rests
// there for two seconds and comes back: its force is that of where it stood.
TEST(ImageLatencyEstimatorTest, APictureThatStaysIsDoubtedAsLongAsTheArmIsElsewhere) {
  const double stays = 3.25;  // at half the depth
  const Outcome outcome = Press([&](double t) { return t > stays && t < 3.9 ? t - stays : 0.0; });
  EXPECT_EQ(outcome.wrong, 0);
  EXPECT_GT(outcome.doubted, 0.4 * kRate);
}

}  // namespace
}  // namespace palpate
