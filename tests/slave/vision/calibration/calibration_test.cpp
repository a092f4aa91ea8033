// Tests calibration with boards seen by known cameras.
#include "slave/vision/calibration/calibration.h"

#include <algorithm>
#include <random>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/slave/vision/stereo/test_rigs.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr ImageSizes kSizes{{640, 480}, {640, 480}};
Board TestBoard() {
  return {9, 6, 0.008};
}

Corners ProjectCorners(const Lens& lens, const Eigen::Isometry3d& X_CB, double sigma,
                       std::mt19937* random) {
  std::normal_distribution<double> noise(0, 1);
  Corners corners;
  const Board board = TestBoard();
  for (int i = 0; i < board.columns * board.rows; ++i) {
    const Eigen::Vector3d p_B(board.square * (i % board.columns),
                              board.square * (i / board.columns), 0);
    const Eigen::Vector2d at = *Project(lens, X_CB * p_B);
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

std::vector<BoardView> ProjectPairs(const StereoRig& rig, int count, double tilt, double sigma) {
  std::mt19937 random(11);
  std::vector<BoardView> pairs;
  for (const Eigen::Isometry3d& X_LB : Poses(count, tilt, &random)) {
    Corners left = ProjectCorners(rig.left, X_LB, sigma, &random);
    pairs.push_back({std::move(left), ProjectCorners(rig.right, rig.X_RL * X_LB, sigma, &random)});
  }
  return pairs;
}

// Corners are floats: 640 px are rounded by 3e-5 px, which twelve boards average to 1e-6 of f.
TEST(PairCalibrationTest, FindsTheRigThatSawTheBoards) {
  const StereoRig rig = VergedTestRig({-0.2, 0.05, 0.001, -0.001, 0});
  const auto found = Calibrate(TestBoard(), ProjectPairs(rig, 12, 0.5, 0), kSizes);
  EXPECT_LT(found.rig.rms_px, 1e-3);
  EXPECT_NEAR(found.rig.left.fx, 800, 0.1);
  EXPECT_NEAR(found.rig.right.cy, 240, 0.1);
  EXPECT_NEAR(found.rig.baseline(), 0.06, 1e-5);
  EXPECT_LT((found.rig.X_RL.matrix() - rig.X_RL.matrix()).norm(), 1e-3);
  EXPECT_TRUE(found.dropped.empty());
}

std::vector<std::size_t> DroppedOf(const Calibration& found) {
  std::vector<std::size_t> dropped;
  for (const auto& d : found.dropped) dropped.push_back(d.view);
  std::sort(dropped.begin(), dropped.end());
  return dropped;
}

// Pair 4's right image is of another pose; in pairs 7 and 9 the board moved by 1 mm (3 px),
// across and along the baseline. A shift along it looks like another distance: only the size of the
// board's image contradicts that, by 3 px of 200.
TEST(PairCalibrationTest, LeavesOutPairsWhoseBoardMovedBetweenTheShots) {
  const StereoRig rig = VergedTestRig();
  auto pairs = ProjectPairs(rig, 12, 0.5, 0.1);
  std::mt19937 random(12);
  const auto poses = Poses(2, 0.5, &random);
  pairs[4].right = ProjectCorners(rig.right, rig.X_RL * poses[0], 0.1, &random);
  for (cv::Point2f& p : pairs[7].right) p.y += 3;
  for (cv::Point2f& p : pairs[9].right) p.x += 3;
  const auto found = Calibrate(TestBoard(), pairs, kSizes);
  EXPECT_THAT(DroppedOf(found), ElementsAre(4, 7, 9));
  EXPECT_NEAR(found.rig.baseline(), 0.06, 0.003);
  EXPECT_LT(found.rig.rms_px, 0.15);  // the noise of both axes: 0.1 sqrt 2
  EXPECT_EQ(found.used.size(), 9U);
}

// None of 12 pairs with normal noise is rejected, whatever the noise level.
class GoodPairsTest : public testing::TestWithParam<double> {};

TEST_P(GoodPairsTest, AreNotRejected) {
  const auto found =
      Calibrate(TestBoard(), ProjectPairs(VergedTestRig(), 12, 0.5, GetParam()), kSizes);
  EXPECT_TRUE(found.dropped.empty());
}

INSTANTIATE_TEST_SUITE_P(, GoodPairsTest, testing::Values(0.1, 0.02, 0.3));

TEST(PairCalibrationTest, ABoardThatLooksTheSameAfterHalfATurnIsRefused) {
  const auto pairs = ProjectPairs(VergedTestRig(), 4, 0.5, 0.1);
  EXPECT_THAT(Thrown<std::runtime_error>([&] {
                Calibrate({6, 6, 0.008}, pairs, kSizes);
              }),
              HasSubstr("expected an odd and an even count of corners"));
}

TEST(PairCalibrationTest, ExchangedSidesAreRefused) {
  auto pairs = ProjectPairs(VergedTestRig(), 8, 0.5, 0.1);
  EXPECT_THAT(Calibrate(TestBoard(), pairs, kSizes).reasons, testing::IsEmpty());
  for (BoardView& pair : pairs) std::swap(pair.left, pair.right);
  EXPECT_THAT(Calibrate(TestBoard(), pairs, kSizes).reasons,
              ElementsAre(HasSubstr("left and right are exchanged")));
}

// Every right image shows the next pose: a common fit has errors of tens of pixels.
TEST(PairCalibrationTest, PairsThatShareNoPoseAreRefused) {
  auto pairs = ProjectPairs(VergedTestRig(), 6, 0.5, 0.1);
  std::vector<Corners> rights;
  for (const BoardView& pair : pairs) rights.push_back(pair.right);
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i].right = rights[(i + 1) % pairs.size()];
  EXPECT_THAT(Calibrate(TestBoard(), pairs, kSizes).reasons,
              testing::Contains(HasSubstr("the corner residual")));
  EXPECT_THAT(Thrown<std::runtime_error>([&] {
                Calibrate(TestBoard(), {pairs[0], pairs[1]}, kSizes);
              }),
              HasSubstr("2 images or pairs show the board: expected 3"));
}

TEST(PairCalibrationTest, TheSameImagesTwiceAreRefused) {
  auto pairs = ProjectPairs(VergedTestRig(), 8, 0.5, 0.1);
  for (BoardView& pair : pairs) pair.right = pair.left;
  EXPECT_THAT(Calibrate(TestBoard(), pairs, kSizes).reasons,
              testing::Contains(HasSubstr("both cameras have the same position")));
}

// Views of one camera, from those of a pair.
std::vector<BoardView> LeftOf(std::vector<BoardView> views) {
  for (BoardView& view : views) view.right.clear();
  return views;
}

TEST(LensCalibrationTest, AViewOfAnotherBoardIsLeftOut) {
  auto views = LeftOf(ProjectPairs(VergedTestRig(), 8, 0.5, 0.1));
  EXPECT_TRUE(Calibrate(TestBoard(), views, kSizes).dropped.empty());
  for (std::size_t i = 0; i < views[3].left.size(); i += 2)
    views[3].left[i].x += 4;  // a bent board
  const auto found = Calibrate(TestBoard(), views, kSizes);
  EXPECT_THAT(DroppedOf(found), ElementsAre(3));
  EXPECT_THAT(found.used, ElementsAre(0, 1, 2, 4, 5, 6, 7));
  EXPECT_NEAR(found.rig.left.fx, 800, 8);
}

// Boards that all face the camera separate focal length from distance badly: the fits without one
// view each disagree.
TEST(TrustTest, BoardsWithoutTiltAreRefused) {
  const auto judge = [](double tilt) {
    return Calibrate(TestBoard(), LeftOf(ProjectPairs(VergedTestRig(), 8, tilt, 0.2)), kSizes)
        .reasons;
  };
  EXPECT_TRUE(judge(0.6).empty());
  EXPECT_THAT(judge(0.02), testing::Contains(HasSubstr("the focal length has a sigma")));
}

// Three copies of each of three views give no more information than the three views.
TEST(TrustTest, RepeatedViewsCountOnce) {
  const auto views = LeftOf(ProjectPairs(VergedTestRig(), 3, 0.5, 0.1));
  auto repeated = views;
  for (int k = 0; k < 2; ++k) repeated.insert(repeated.end(), views.begin(), views.end());
  EXPECT_THAT(Calibrate(TestBoard(), repeated, kSizes).reasons,
              testing::Contains(HasSubstr("3 different images are too few")));
}

}  // namespace
}  // namespace palpate
