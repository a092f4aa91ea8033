#include "slave/vision/texture/flow_tracker.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "tests/slave/vision/texture/texture_images.h"

namespace palpate {
namespace {

const std::vector<Eigen::Vector2d> kAt{{100, 100}, {160, 120}, {210, 130}};

// Reference: the known motion. A tracker from image to image would accumulate its errors: after 200
// images with 0.03 px each, 0.4 px. This tracker is as accurate at the end as at the beginning.
TEST(FlowTrackerTest, PositionsDoNotDriftOverALongPath) {
  WavyTexture texture;
  FlowTracker tracker(texture.Image({}, 2), kAt, {});
  double first_half = 0, second_half = 0;
  constexpr int kImages = 200;
  for (int k = 1; k <= kImages; ++k) {
    const Eigen::Vector2d by(20 * std::sin(0.11 * k), 12 * std::sin(0.07 * k));
    const auto& windows = tracker.Track(texture.Image(Shifted(by.x(), by.y()), 2));
    for (std::size_t i = 0; i < kAt.size(); ++i) {
      ASSERT_TRUE(windows[i].seen) << k;
      const double miss = (windows[i].warp.p - kAt[i] - by).norm();
      (k <= kImages / 2 ? first_half : second_half) += miss;
    }
  }
  const double each = kImages / 2.0 * static_cast<double>(kAt.size());
  EXPECT_LT(first_half / each, 0.05);
  EXPECT_LT(second_half / each, 0.05);
}

// A slow zoom far beyond the range of pure shifts, with changing light.
TEST(FlowTrackerTest, ApproachAndLightAreFollowed) {
  WavyTexture texture;
  const Eigen::Vector2d centre(160, 120);
  FlowTracker tracker(texture.Image({}, 2), {centre}, {});
  for (int k = 1; k <= 40; ++k) {
    PatchWarp by;
    by.A *= 1 + 0.005 * k;
    by.p = centre - by.A * centre;
    const auto& window = tracker.Track(texture.Image(by, 2, 1 - 0.01 * k, 0.5 * k)).front();
    ASSERT_TRUE(window.seen) << k;
    ASSERT_LT((window.warp.p - centre).norm(), 0.15) << k;
  }
}

TEST(FlowTrackerTest, CoveredWindowsAreLostAndFoundAgainWithTheirIdentity) {
  WavyTexture texture;
  FlowTracker tracker(texture.Image({}, 2), kAt, {});
  for (int k = 1; k <= 30; ++k) {
    const Eigen::Vector2d by(0.8 * k, 0.3 * k);
    cv::Mat image = texture.Image(Shifted(by.x(), by.y()), 2);
    const bool covered = k >= 10 && k < 20;
    if (covered) {
      const Eigen::Vector2d p = kAt[1] + by;
      cv::circle(image, {static_cast<int>(p.x()), static_cast<int>(p.y())}, 22, 90, -1);
    }
    const auto& windows = tracker.Track(image);
    ASSERT_TRUE(windows[0].seen) << k;
    ASSERT_EQ(windows[1].seen, !covered) << k;
    for (std::size_t i = 0; i < kAt.size(); ++i) {
      if (!windows[i].seen) continue;
      ASSERT_LT((windows[i].warp.p - kAt[i] - by).norm(), 0.15) << k << ' ' << i;
    }
  }
}

TEST(FlowTrackerTest, WindowsThatLeaveTheImageAreLostAndComeBack) {
  WavyTexture texture;
  FlowTracker tracker(texture.Image({}, 2), {{40, 120}}, {});
  for (int k = 1; k <= 24; ++k) {
    const double x = -4.0 * (k <= 12 ? k : 24 - k);
    const auto& window = tracker.Track(texture.Image(Shifted(x, 0), 2)).front();
    const bool inside = 40 + x > 20;
    if (inside && (k < 6 || k > 20)) {
      ASSERT_TRUE(window.seen) << k;
      ASSERT_LT(std::abs(window.warp.p.x() - 40 - x), 0.15) << k;
    }
    if (40 + x < 10) {
      ASSERT_FALSE(window.seen) << k;
    }
  }
}

TEST(FlowTrackerTest, TheOtherCamerasImageMayBeLarger) {
  WavyTexture texture;
  const cv::Mat large = texture.Image({});
  const FlowTracker tracker(large(cv::Rect(100, 80, 80, 80)), {{40, 40}}, {});
  FlowTracker other = tracker.InOtherCamera(large);
  ASSERT_TRUE(other.Place(0, Shifted(142, 121)));
  EXPECT_LT((other.windows().front().warp.p - Eigen::Vector2d(140, 120)).norm(), 0.05);
  EXPECT_TRUE(other.Track(large).front().seen);
}

TEST(FlowTrackerTest, WhatCannotBeIsRefusedAtOnce) {
  const cv::Mat image = WavyTexture().Image({});
  const auto with = [&](auto change) {
    FlowOptions options;
    change(options);
    FlowTracker(image, kAt, options);
  };
  EXPECT_THROW(with([](FlowOptions& o) { o.window = 30; }), std::invalid_argument);
  EXPECT_THROW(with([](FlowOptions& o) { o.window = 7; }), std::invalid_argument);
  EXPECT_THROW(with([](FlowOptions& o) { o.min_correlation = 1; }), std::invalid_argument);
  EXPECT_THROW(with([](FlowOptions& o) { o.refind_correlation = NAN; }), std::invalid_argument);
  EXPECT_THROW(with([](FlowOptions& o) { o.max_return_miss = 0; }), std::invalid_argument);
  EXPECT_THROW(FlowTracker(cv::Mat(), kAt, {}), std::invalid_argument);
  EXPECT_THROW(FlowTracker(cv::Mat::zeros(240, 320, CV_16U), kAt, {}), std::invalid_argument);
  EXPECT_THROW(FlowTracker(cv::Mat::zeros(20, 320, CV_8U), kAt, {}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
