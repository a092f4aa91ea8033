// Boards seen by cameras that are known.
#include <algorithm>
#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "slave/vision/calibration/pair_calibration.h"
#include "slave/vision/calibration/trust.h"
#include "tests/slave/vision/stereo/test_rigs.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr PairSizes kSizes{{640, 480}, {640, 480}};
Board TestBoard() {
  return {Board::Pattern::kChessboard, 9, 6, 0.008};
}

Corners See(const Lens& lens, const Eigen::Isometry3d& X_CB, double sigma, std::mt19937* random) {
  std::normal_distribution<double> noise(0, 1);
  Corners corners;
  for (const cv::Point3f& p : BoardPoints(TestBoard())) {
    const Eigen::Vector2d at = *Project(lens, X_CB * Eigen::Vector3d(p.x, p.y, p.z));
    const double du = noise(*random), dv = noise(*random);
    corners.emplace_back(static_cast<float>(at.x() + sigma * du),
                         static_cast<float>(at.y() + sigma * dv));
  }
  return corners;
}

// Boards about 250 mm away, tilted by up to `tilt` [rad].
std::vector<Eigen::Isometry3d> Poses(int count, double tilt, std::mt19937* random) {
  std::uniform_real_distribution<double> any(-1, 1);
  std::vector<Eigen::Isometry3d> poses;
  for (int i = 0; i < count; ++i) {
    Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
    const double a = any(*random), b = any(*random), c = any(*random);
    const double x = any(*random), y = any(*random), z = any(*random);
    X.translation() = Eigen::Vector3d(0.03 + 0.02 * x, 0.02 * y, 0.25 + 0.04 * z);
    X.rotate(Eigen::AngleAxisd(tilt * a, Eigen::Vector3d::UnitX()))
        .rotate(Eigen::AngleAxisd(tilt * b, Eigen::Vector3d::UnitY()))
        .rotate(Eigen::AngleAxisd(0.3 * c, Eigen::Vector3d::UnitZ()))
        .translate(Eigen::Vector3d(-0.032, -0.02, 0));
    poses.push_back(X);
  }
  return poses;
}

std::vector<PairView> SeePairs(const StereoRig& rig, int count, double tilt, double sigma) {
  std::mt19937 random(11);
  std::vector<PairView> pairs;
  for (const Eigen::Isometry3d& X_LB : Poses(count, tilt, &random)) {
    Corners left = See(rig.left, X_LB, sigma, &random);
    pairs.push_back({std::move(left), See(rig.right, rig.X_RL * X_LB, sigma, &random)});
  }
  return pairs;
}

// Corners are floats: 640 px are rounded by 3e-5 px, which twelve boards average to 1e-6 of f.
TEST(PairCalibrationTest, FindsTheRigThatSawTheBoards) {
  const StereoRig rig = VergedTestRig({-0.2, 0.05, 0.001, -0.001, 0});
  const auto found = CalibratePair(TestBoard(), SeePairs(rig, 12, 0.5, 0), kSizes);
  EXPECT_LT(found.fit.rig.rms_px, 1e-3);
  EXPECT_NEAR(found.fit.rig.left.fx, 800, 0.1);
  EXPECT_NEAR(found.fit.rig.right.cy, 240, 0.1);
  EXPECT_NEAR(found.fit.rig.baseline(), 0.06, 1e-5);
  EXPECT_LT((found.fit.rig.X_RL.matrix() - rig.X_RL.matrix()).norm(), 1e-3);
  EXPECT_TRUE(found.dropped.empty());
}

TEST(PairCalibrationTest, LeavesOutAPairWhoseBoardMovedBetweenTheShots) {
  const StereoRig rig = VergedTestRig();
  auto pairs = SeePairs(rig, 12, 0.5, 0.1);
  std::mt19937 random(12);
  const auto poses = Poses(2, 0.5, &random);
  pairs[4].right = See(rig.right, rig.X_RL * poses[0], 0.1, &random);
  for (cv::Point2f& p : pairs[7].right) p.y += 3;  // by 1 mm only
  const auto found = CalibratePair(TestBoard(), pairs, kSizes);
  std::vector<std::size_t> dropped;
  for (const auto& d : found.dropped) dropped.push_back(d.pair);
  std::sort(dropped.begin(), dropped.end());
  EXPECT_THAT(dropped, ElementsAre(4, 7));
  EXPECT_NEAR(found.fit.rig.baseline(), 0.06, 0.003);
  EXPECT_LT(found.fit.rig.rms_px, 0.15);  // the noise of both axes: 0.1 sqrt 2
}

TEST(PairCalibrationTest, PairsThatShareNoPoseAreRefused) {
  const StereoRig rig = VergedTestRig();
  auto pairs = SeePairs(rig, 6, 0.5, 0.1);
  std::vector<Corners> rights;
  for (const PairView& pair : pairs) rights.push_back(pair.right);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].right = rights[(i + 1) % pairs.size()];
  try {
    const auto found = CalibratePair(TestBoard(), pairs, kSizes);
    TrustQuestion question;
    question.used = found.used.size();
    question.given = pairs.size();
    question.rms_px = found.fit.rig.rms_px;
    EXPECT_FALSE(Judge(question).reasons.empty());
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("agree"));
  }
  EXPECT_THROW(CalibratePair(TestBoard(), {pairs[0], pairs[1]}, kSizes), std::runtime_error);
}

// Boards that all face the camera tell focal length from distance badly: the halves disagree.
TEST(TrustTest, BoardsWithoutTiltAreRefusedByTheirHalves) {
  const auto judge = [](double tilt) {
    std::vector<Corners> views;
    for (const PairView& pair : SeePairs(VergedTestRig(), 8, tilt, 0.2)) views.push_back(pair.left);
    const LensCalibration found = CalibrateLens(TestBoard(), views, kSizes.left);
    TrustQuestion question;
    question.quantity = "focal length";
    question.used = question.given = views.size();
    question.rms_px = found.rms_px;
    question.halves = CheckHalves(TestBoard(), views, kSizes.left, found.lens.fx);
    return Judge(question).reasons;
  };
  EXPECT_TRUE(judge(0.6).empty());
  EXPECT_THAT(judge(0.02), testing::Contains(HasSubstr("halves")));
}

// If a half estimates with variance 2 s^2, |a - b| is 2 s times a unit normal's size.
TEST(TrustTest, TheSigmaOfTheWholeIsHalfTheDifferenceOfHalves) {
  HalvesCheck halves;
  halves.odd_even = 0.02;
  halves.random = std::vector<double>(kRandomHalves, 0.02);
  EXPECT_DOUBLE_EQ(halves.sigma(), 0.01);
  EXPECT_DOUBLE_EQ(halves.worst(), 0.02);
}

TEST(TrustTest, ExchangedSidesAreSeenInTheRig) {
  const StereoRig rig = VergedTestRig();
  EXPECT_FALSE(AreSidesExchanged(rig));
  EXPECT_TRUE(AreSidesExchanged(Exchanged(rig)));
  StereoRig one_above_the_other;
  one_above_the_other.X_RL.translation() = Eigen::Vector3d(0.001, 0.06, 0);
  EXPECT_FALSE(AreSidesExchanged(one_above_the_other));
}

// A board drawn with corners at known places; they are found to a tenth of a pixel.
TEST(BoardTest, ChessboardsAndCirclesAreFoundWhereTheyWereDrawn) {
  for (const auto pattern : {Board::Pattern::kChessboard, Board::Pattern::kCircles}) {
    const Board board{pattern, 7, 5, 0.01};
    constexpr int kStep = 40;
    cv::Mat picture(400, 480, CV_8UC3, cv::Scalar(230, 230, 230));
    const bool chess = pattern == Board::Pattern::kChessboard;
    for (int j = 0; j < (chess ? 6 : 5); ++j) {
      for (int i = 0; i < (chess ? 8 : 7); ++i) {
        const cv::Scalar dark(20, 20, 20);
        const cv::Point at(80 + kStep * i, 80 + kStep * j);
        if (!chess) cv::circle(picture, at, 10, dark, cv::FILLED, cv::LINE_AA);
        if (chess && (i + j) % 2 == 0) {
          cv::rectangle(picture, {at.x, at.y, kStep, kStep}, dark, cv::FILLED);
        }
      }
    }
    for (const bool negative : {false, true}) {
      cv::Mat shown = picture;
      if (negative && !chess) cv::bitwise_not(picture, shown);
      auto corners = FindBoard(BoardGrey(shown), board);
      ASSERT_TRUE(corners);
      Corners expected;
      const double first = chess ? 80 + kStep - 0.5 : 80;
      for (int j = 0; j < 5; ++j) {
        for (int i = 0; i < 7; ++i) {
          expected.emplace_back(static_cast<float>(first + kStep * i),
                                static_cast<float>(first + kStep * j));
        }
      }
      if (cv::norm(corners->front() - expected.front()) > kStep) {
        std::reverse(corners->begin(), corners->end());
      }
      for (std::size_t i = 0; i < expected.size(); ++i) {
        EXPECT_LT(cv::norm((*corners)[i] - expected[i]), 0.1) << i;
      }
    }
    EXPECT_FALSE(FindBoard(BoardGrey(picture), {pattern, 9, 8, 0.01}));
  }
  EXPECT_THROW(BoardGrey(cv::Mat()), std::runtime_error);
  EXPECT_THROW(BoardGrey(cv::Mat1f(9, 9)), std::runtime_error);
}

}  // namespace
}  // namespace palpate
