#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "shared/state/driven_clock.h"
#include "slave/capture/frame_source.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;

constexpr int kPairWidth = 32, kPairHeight = 24;

Scene PairScene(const Scratch& scratch, const std::string& left = "l%d.png",
                const std::string& right = "r%d.png") {
  Scene scene;
  scene.name = "recorded";
  scene.sense.Set(PointsOptions{});
  scene.sense.Find<StereoCameras>()->source = StereoCameras::Source::kFiles;
  scene.sense.Find<StereoCameras>()->left = (scratch.path() / left).string();
  scene.sense.Find<StereoCameras>()->right = (scratch.path() / right).string();
  scene.sense.Find<StereoCameras>()->rate = 50;
  return scene;
}

Scene DepthScene(const Scratch& scratch, const std::string& pattern) {
  Scene scene;
  scene.name = "depth";
  scene.sense.Set(PointsOptions{.cameras = DepthImages{}});
  scene.sense.Find<DepthImages>()->pattern = (scratch.path() / pattern).string();
  return scene;
}

void Write(const Scratch& scratch, const std::string& name, double level, int type = CV_8UC1,
           int width = kPairWidth) {
  const cv::Mat image(kPairHeight, width, type, cv::Scalar::all(level));
  ASSERT_TRUE(cv::imwrite((scratch.path() / name).string(), image));
}

void WritePairs(const Scratch& scratch, int count) {
  for (int k = 0; k < count; ++k) {
    Write(scratch, cv::format("l%d.png", k), k);
    Write(scratch, cv::format("r%d.png", k), 100 + k);
  }
}

// Returns the error message when the scene is opened and read to its end.
std::string Message(const Scene& scene) {
  return Thrown<std::runtime_error>([&] {
    const DrivenClock clock;
    const auto source = OpenStereo(scene);
    while (source->Next({})) continue;
  });
}

struct StereoFilesTest : testing::Test {
  const Scratch scratch;
};

TEST_F(StereoFilesTest, PairsComeOnceInTheOrderOfTheirNumbersWithStampsAtTheRate) {
  WritePairs(scratch, 12);
  for (const bool glob : {false, true}) {
    const DrivenClock clock;
    const auto source =
        OpenStereo(glob ? PairScene(scratch, "l*.png", "r*.png") : PairScene(scratch));
    EXPECT_THAT(source->description(), EndsWith("(12 pairs)"));
    Time first{};
    for (int k = 0; k < 12; ++k) {
      const auto pair = source->Next({});
      ASSERT_TRUE(pair) << k;
      if (k == 0) first = pair->sensed_at;
      EXPECT_EQ(pair->sequence, static_cast<std::uint64_t>(k + 1));
      EXPECT_NEAR(SecondsBetween(first, pair->sensed_at), 0.02 * k, 2e-9);
      for (const cv::Mat& image : {pair->left, pair->right}) {
        ASSERT_EQ(image.size(), cv::Size(kPairWidth, kPairHeight));
        ASSERT_EQ(image.type(), CV_8UC1);
        EXPECT_TRUE(image.isContinuous());
      }
      EXPECT_EQ(cv::norm(pair->left, cv::Mat(kPairHeight, kPairWidth, CV_8UC1, cv::Scalar(k))), 0);
      EXPECT_EQ(
          cv::norm(pair->right, cv::Mat(kPairHeight, kPairWidth, CV_8UC1, cv::Scalar(100 + k))), 0);
    }
    EXPECT_FALSE(source->Next({}));
    EXPECT_FALSE(source->Next({})) << "an ended source stays ended";
  }
}

TEST_F(StereoFilesTest, MissingImagesDoNotCauseWrongPairs) {
  WritePairs(scratch, 5);
  std::filesystem::remove(scratch.path() / "l2.png");
  std::filesystem::remove(scratch.path() / "r3.png");
  EXPECT_THAT(Message(PairScene(scratch, "l*.png", "r*.png")),
              AllOf(HasSubstr("pair 3"), HasSubstr("l3.png"), HasSubstr("r2.png")));
}

TEST_F(StereoFilesTest, SizesThatDifferNameTheFile) {
  WritePairs(scratch, 3);
  Write(scratch, "r0.png", 0, CV_8UC1, 40);
  EXPECT_THAT(Message(PairScene(scratch)),
              AllOf(HasSubstr("r0.png: image 1: 32 x 24 and 40 x 24 px"), HasSubstr("one size")));
  Write(scratch, "r0.png", 0);
  Write(scratch, "l2.png", 0, CV_8UC1, 48);
  EXPECT_THAT(Message(PairScene(scratch)), AllOf(HasSubstr("l2.png: image 3: 48 x 24 px"),
                                                 HasSubstr("first one's size, 32 x 24 px")));
}

TEST_F(StereoFilesTest, DepthImagesAreUnchangedAndHaveNoRightImage) {
  for (int k = 0; k < 3; ++k) Write(scratch, cv::format("d%d.png", k), 2500 + k, CV_16UC1);
  const DrivenClock clock;
  const auto source = OpenStereo(DepthScene(scratch, "d*.png"));
  EXPECT_THAT(source->description(), EndsWith("(3 depth images)"));
  for (int k = 0; k < 3; ++k) {
    const auto pair = source->Next({});
    ASSERT_TRUE(pair);
    EXPECT_TRUE(pair->right.empty());
    ASSERT_EQ(pair->left.type(), CV_16UC1);
    EXPECT_EQ(pair->left.at<ushort>(7, 7), 2500 + k);
  }
  EXPECT_FALSE(source->Next({}));
}

}  // namespace
}  // namespace palpate
