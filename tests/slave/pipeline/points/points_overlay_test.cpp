#include "slave/pipeline/points/points_overlay.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/slave/pipeline/points/watched_membrane.h"

namespace palpate {
namespace {

using testing_fakes::DotPairs;
using testing_fakes::MembraneScene;

// Pixels that are no grey, within `reach` of `p`.
int Coloured(const cv::Mat& picture, const Eigen::Vector2d& p, int reach) {
  int count = 0;
  for (int v = -reach; v <= reach; ++v) {
    for (int u = -reach; u <= reach; ++u) {
      const int x = static_cast<int>(p.x()) + u, y = static_cast<int>(p.y()) + v;
      if (x < 0 || y < 0 || x >= picture.cols || y >= picture.rows) continue;
      const auto& pixel = picture.at<cv::Vec3b>(y, x);
      count += pixel[0] != pixel[1] || pixel[1] != pixel[2] ? 1 : 0;
    }
  }
  return count;
}

class PointsOverlayTest : public ::testing::Test {
 protected:
  PointsOverlayTest()
      : scene_(MembraneScene()), tracker_(MakeSurfacePointTracker(scene_, RigOf(scene_))) {
    while (!tracker_->at_rest_known()) tracker_->Process(pair_);
  }
  Scene scene_;
  std::unique_ptr<SurfacePointTracker> tracker_;
  StereoPair pair_ = DotPairs().Draw({}, 1);
};

TEST_F(PointsOverlayTest, EveryDotIsMarkedWhereItIsSeen) {
  const SurfaceObservation& seen = tracker_->Process(pair_);
  const PointsOverlay overlay = MakePointsOverlay(*tracker_, seen, ContactEstimate{});
  ASSERT_EQ(overlay.seen_I.size(), 31U);
  EXPECT_TRUE(overlay.lost_I.empty());
  const cv::Mat drawn = DrawPoints(pair_.left, overlay, 4);
  ASSERT_EQ(drawn.type(), CV_8UC3);
  for (const Eigen::Vector2d& p : overlay.seen_I) EXPECT_GT(Coloured(drawn, p, 10), 20);
  EXPECT_EQ(pair_.left.type(), CV_8UC1);  // untouched
}

TEST_F(PointsOverlayTest, WhatIsLostIsMarkedWhereItWas) {
  tracker_->Process(pair_);
  const SurfaceObservation& lost = tracker_->Process(DotPairs().Draw({0, {0, 0}, true}, 2));
  const PointsOverlay overlay = MakePointsOverlay(*tracker_, lost, ContactEstimate{});
  EXPECT_TRUE(overlay.seen_I.empty());
  EXPECT_EQ(overlay.lost_I.size(), 31U);
}

TEST_F(PointsOverlayTest, ALoadIsMarkedAtItsPlaceAndInNumbers) {
  ContactEstimate estimate;
  estimate.p_S_contact = {0.01, 0.005, 0};
  estimate.depth = 0.001;
  estimate.force = Eigen::Vector3d(0, 0, 2);
  estimate.validity = Validity::kValid;
  const PointsOverlay overlay = MakePointsOverlay(*tracker_, tracker_->Process(pair_), estimate);
  ASSERT_TRUE(overlay.place_I.has_value());
  EXPECT_LT((*overlay.place_I - *tracker_->Project(estimate.p_S_contact)).norm(), 1e-9);
  const cv::Mat drawn = DrawPoints(pair_.left, overlay, 4);
  EXPECT_GT(Coloured(drawn, *overlay.place_I, 30), 60);
  EXPECT_GT(Coloured(drawn, {60, 15}, 20), 50);  // the words
  // Half of what the hand can show: a ring of half the largest radius, a tenth of the height.
  const Eigen::Vector2d on_ring = *overlay.place_I + Eigen::Vector2d(-24, 0);
  EXPECT_GT(Coloured(drawn, on_ring, 2), 3);
  EXPECT_EQ(Coloured(DrawPoints(pair_.left, overlay, 0), on_ring, 2), 0) << "nobody says how much";
  // Across the line of sight it is not foreshortened.
  estimate.force = Eigen::Vector3d(4, 0, 0);
  const PointsOverlay aside = MakePointsOverlay(*tracker_, tracker_->Process(pair_), estimate);
  EXPECT_NEAR(aside.along_I.norm(), 1, 0.05);
}

TEST_F(PointsOverlayTest, NumbersThatAreNoneAndPlacesFarOutDrawNothingAndBreakNothing) {
  ContactEstimate estimate;
  estimate.depth = 0.001;
  estimate.force = Eigen::Vector3d(0, 0, 1e300);
  estimate.p_S_contact = {1e6, -1e6, 0.3};
  const SurfaceObservation& seen = tracker_->Process(pair_);
  EXPECT_EQ(DrawPoints(pair_.left, MakePointsOverlay(*tracker_, seen, estimate), 0).rows, 480);
  EXPECT_EQ(DrawPoints(pair_.left, MakePointsOverlay(*tracker_, seen, estimate), 1).rows, 480);
  estimate.p_S_contact.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_FALSE(MakePointsOverlay(*tracker_, seen, estimate).place_I.has_value());
}

TEST(DepthPictureTest, DepthsAreStretchedAndHolesStayBlack) {
  cv::Mat depth(4, 6, CV_16UC1, cv::Scalar(1000));
  depth.at<std::uint16_t>(1, 1) = 0;
  depth.at<std::uint16_t>(2, 2) = 1500;
  const cv::Mat grey = AsPicture(depth);
  ASSERT_EQ(grey.type(), CV_8UC1);
  EXPECT_EQ(grey.at<std::uint8_t>(1, 1), 0);
  EXPECT_EQ(grey.at<std::uint8_t>(2, 2), 255);
  EXPECT_LT(grey.at<std::uint8_t>(0, 0), 128);
}

}  // namespace
}  // namespace palpate
