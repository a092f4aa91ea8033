// Real images: ../shared/data/dot_patterns.
#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slave/vision/dots/dot_array.h"
#include "slave/vision/dots/dot_tracker.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

const std::filesystem::path kDots = SourcePath("/../shared/data/dot_patterns");

std::vector<std::filesystem::path> ImageFiles(const std::filesystem::path& folder,
                                              const std::string& prefix) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (entry.path().filename().string().starts_with(prefix)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<Eigen::Vector2d> SixBySix() {
  std::vector<Eigen::Vector2d> layout;
  for (int j = 0; j < 6; ++j) {
    for (int i = 0; i < 6; ++i) layout.emplace_back(i, j);
  }
  return layout;
}

// Returns the grid's positions found by OpenCV [px].
std::vector<Eigen::Vector2d> GridPlaces(const cv::Mat& image) {
  std::vector<cv::Point2f> centres;
  EXPECT_TRUE(cv::findCirclesGrid(image, {6, 6}, centres));
  std::vector<Eigen::Vector2d> places;
  for (const cv::Point2f& p : centres) places.emplace_back(p.x + 4, p.y - 3);
  return places;
}

// RMS of centres against a square grid seen through a homography [px].
double HomographyResidual(const std::vector<SightedDot>& dots) {
  std::vector<cv::Point2d> grid, seen;
  for (std::size_t k = 0; k < dots.size(); ++k) {
    grid.emplace_back(static_cast<double>(k % 6), static_cast<double>(k / 6));
    seen.emplace_back(dots[k].dot.centre.x(), dots[k].dot.centre.y());
  }
  const cv::Mat H = cv::findHomography(grid, seen, 0);
  std::vector<cv::Point2d> back;
  cv::perspectiveTransform(grid, back, H);
  double squares = 0;
  for (std::size_t k = 0; k < back.size(); ++k) {
    squares += std::pow(back[k].x - seen[k].x, 2) + std::pow(back[k].y - seen[k].y, 2);
  }
  return std::sqrt(squares / static_cast<double>(2 * back.size()));
}

// Reference: the printed grid has exactly 36 dots. The residual of the centres relative to a square
// grid through a homography includes the uncorrected lens and the paper's curvature besides the
// centroids' error: 0.14, 0.24 and 0.19 px per axis.
TEST(RealDots, EveryGridImageShowsItsThirtySixDotsAndNoOther) {
  const auto files = ImageFiles(kDots, "grid36_");
  if (files.empty()) GTEST_SKIP() << "no images in " << kDots;
  for (const auto& file : files) {
    const cv::Mat image = cv::imread(file.string(), cv::IMREAD_GRAYSCALE);
    DotFinder finder(DotFinder::Params{});
    std::vector<Dot> dots;
    ASSERT_TRUE(finder.Find(image, &dots));
    EXPECT_EQ(dots.size(), 36u) << file;
    DotTracker tracker(SixBySix(), GridPlaces(image), {});
    ASSERT_TRUE(tracker.Process(image)) << file;
    EXPECT_EQ(tracker.seen(), 36) << file;
    const double residual = HomographyResidual(tracker.dots());
    EXPECT_LT(residual, 0.4) << file;
  }
}

const std::vector<Eigen::Vector2d> kFive = {{-1, -1}, {1, -1}, {0, 0}, {-1, 1}, {1, 1}};

DotTracker::Params OfFive() {
  DotTracker::Params params;
  params.finder.tone = DotTone::kLight;
  params.any_tone = false;
  return params;
}

// Among the five in the first image: the largest, and the nearest to it in each quadrant.
std::vector<Eigen::Vector2d> PlacesIn(const cv::Mat& image) {
  DotFinder finder(OfFive().finder);
  std::vector<Dot> dots;
  EXPECT_TRUE(finder.Find(image, &dots));
  std::vector<Eigen::Vector2d> places(5, Eigen::Vector2d::Constant(1e3));
  places[2] = std::max_element(dots.begin(), dots.end(), [](const Dot& a, const Dot& b) {
                return a.area < b.area;
              })->centre;
  for (const Dot& dot : dots) {
    const Eigen::Vector2d d = dot.centre - places[2];
    for (const std::size_t k : {0u, 1u, 3u, 4u}) {
      const bool there = d.x() * kFive[k].x() > 40 && d.y() * kFive[k].y() > 25;
      if (there && d.norm() < (places[k] - places[2]).norm()) places[k] = dot.centre;
    }
  }
  return places;
}

// The central dot is by far the largest; the others lie around it as in the layout.
void ExpectNamed(const DotTracker& tracker, const std::string& where) {
  ASSERT_EQ(tracker.seen(), 5) << where;
  const Dot& middle = tracker.dots()[2].dot;
  EXPECT_GT(middle.area, 1500) << where;
  for (const std::size_t k : {0u, 1u, 3u, 4u}) {
    const Dot& dot = tracker.dots()[k].dot;
    EXPECT_LT(dot.area, 300) << where;
    const Eigen::Vector2d from_middle = dot.centre - middle.centre;
    EXPECT_GT(from_middle.x() * kFive[k].x(), 40) << where << " " << k;
    EXPECT_GT(from_middle.y() * kFive[k].y(), 25) << where << " " << k;
    EXPECT_LT(from_middle.norm(), 120) << where << " " << k;
  }
}

// Reference: the box's large dot is by far the largest one found in an image, and lies between the
// other four. All other dots found are outside the box. The result must not depend on which image
// comes first and in which order the others follow.
TEST(RealDots, FiveDotsAreIdentifiedFromAnyImageInBothDirections) {
  const auto files = ImageFiles(kDots / "five_dots_seq", "frame_");
  if (files.empty()) GTEST_SKIP() << "no images in " << kDots;
  std::vector<cv::Mat> images;
  for (const auto& file : files) images.push_back(cv::imread(file.string(), cv::IMREAD_GRAYSCALE));
  const int count = static_cast<int>(images.size());
  for (int start = 0; start < count; ++start) {
    for (const int way : {1, -1}) {
      DotTracker tracker(kFive, PlacesIn(images[static_cast<std::size_t>(start)]), OfFive());
      for (int i = start; i >= 0 && i < count; i += way) {
        const std::string where = std::to_string(i) + " from " + std::to_string(start);
        ASSERT_TRUE(tracker.Process(images[static_cast<std::size_t>(i)])) << where;
        ExpectNamed(tracker, where);
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  }
}

}  // namespace
}  // namespace palpate
