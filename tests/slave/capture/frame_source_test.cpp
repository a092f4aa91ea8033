#include "slave/capture/frame_source.h"

#include <chrono>
#include <cstdint>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "shared/state/driven_clock.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

Scene SceneWith(Camera::Source source, const std::string& pattern, const Scratch& scratch) {
  Scene scene;
  scene.name = "recorded";
  scene.file = scratch.path() / "scene.yaml";
  scene.sense.Set(CameraOptions{.camera = Camera{}});
  scene.sense.Find<Camera>()->source = source;
  scene.sense.Find<Camera>()->pattern = (scratch.path() / pattern).string();
  scene.sense.Find<Camera>()->rate = 100;
  scene.sense.Find<Camera>()->size = {0, 0};
  return scene;
}

// Writes images 0, 1, ... whose grey level is their number.
void WriteNumbered(const Scratch& scratch, int count) {
  for (int k = 0; k < count; ++k) {
    const cv::Mat image(24, 32, CV_8UC1, cv::Scalar(k));
    ASSERT_TRUE(cv::imwrite(
        (scratch.path() / std::string("f").append(std::to_string(k)).append(".png")).string(),
        image));
  }
}

std::string OpeningMessage(const Scene& scene) {
  return Thrown<std::runtime_error>([&] { OpenFrameSource(scene); });
}

struct FrameSourceTest : testing::Test {
  const Scratch scratch;
};

// A directory that also contains images of another camera.
TEST_F(FrameSourceTest, ALaterImageOfAnotherSizeIsNamed) {
  WriteNumbered(scratch, 3);
  ASSERT_TRUE(cv::imwrite((scratch.path() / "f1.png").string(), cv::Mat(48, 64, CV_8UC1)));
  for (const bool is_stated : {false, true}) {
    Scene scene = SceneWith(Camera::Source::kFiles, "f%d.png", scratch);
    if (is_stated) scene.sense.Find<Camera>()->size = {32, 24};
    const DrivenClock clock;
    const auto source = OpenFrameSource(scene);
    EXPECT_TRUE(source->Next({}));
    const auto next = [&] { return Thrown<std::runtime_error>([&] { source->Next({}); }); };
    EXPECT_THAT(next(), testing::AllOf(testing::HasSubstr("f1.png: image 2: 64 x 48 px"),
                                       testing::HasSubstr("32 x 24 px")));
  }
}

TEST_F(FrameSourceTest, FilesComeOnceInOrderWithStampsAtTheScenesRate) {
  WriteNumbered(scratch, 30);
  const DrivenClock clock;
  const auto source = OpenFrameSource(SceneWith(Camera::Source::kFiles, "f%d.png", scratch));
  EXPECT_THAT(source->description(), testing::EndsWith("f%d.png (30)"));
  Time first{};
  for (int k = 0; k < 30; ++k) {
    const auto frame = source->Next({});
    ASSERT_TRUE(frame) << k;
    if (k == 0) first = frame->sensed_at;
    EXPECT_EQ(frame->sequence, static_cast<std::uint64_t>(k + 1));
    EXPECT_EQ(frame->image.at<uchar>(5, 5), k);
    EXPECT_NEAR(SecondsBetween(first, frame->sensed_at), 0.01 * k, 2e-9);
  }
  EXPECT_FALSE(source->Next({}));
  EXPECT_FALSE(source->Next({})) << "an ended source stays ended";
}

TEST_F(FrameSourceTest, AtAMissingNumberTheTimeAdvancesAndItIsReported) {
  WriteNumbered(scratch, 12);
  for (const char* name : {"f4.png", "f5.png"}) std::filesystem::remove(scratch.path() / name);
  const DrivenClock clock;
  const auto source = OpenFrameSource(SceneWith(Camera::Source::kFiles, "f%d.png", scratch));
  EXPECT_THAT(source->description(), testing::EndsWith("f%d.png (10, 2 missing)"));
  Time start{};
  std::uint64_t count = 0;
  while (const auto frame = source->Next({})) {
    EXPECT_EQ(frame->sequence, ++count);
    if (count == 1) start = frame->sensed_at;
    // The grey level is the number, images come at 100 Hz; stamps are whole nanoseconds.
    const double number = frame->image.at<std::uint8_t>(0, 0);
    EXPECT_NEAR(SecondsBetween(start, frame->sensed_at), number / 100, 1e-8) << number;
  }
  EXPECT_EQ(count, 10U);
}

TEST_F(FrameSourceTest, StoppingEndsAWaitForAnImage) {
  WriteNumbered(scratch, 2);
  Scene scene = SceneWith(Camera::Source::kFiles, "f%d.png", scratch);
  scene.sense.Find<Camera>()->rate = 1e-3;  // the second image is due in 1000 s
  const auto source = OpenFrameSource(scene);
  ASSERT_TRUE(source->Next({}));
  std::stop_source stop;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    stop.request_stop();
  });
  EXPECT_FALSE(source->Next(stop.get_token()));
}

TEST_F(FrameSourceTest, ASourceNobodyReadsCanBeClosed) {
  WriteNumbered(scratch, 40);  // more than the decoding thread keeps ahead, so it waits
  const DrivenClock clock;
  const auto source = OpenFrameSource(SceneWith(Camera::Source::kFiles, "f%d.png", scratch));
  EXPECT_TRUE(source->Next({}));
}

TEST_F(FrameSourceTest, VideosGiveEveryImage) {
  const std::string file = (scratch.path() / "v.avi").string();
  {
    cv::VideoWriter writer(file, cv::CAP_OPENCV_MJPEG, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'),
                           30, {64, 48});
    ASSERT_TRUE(writer.isOpened());
    for (int k = 0; k < 12; ++k) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(20 * k)));
  }
  const DrivenClock clock;
  const auto source = OpenFrameSource(SceneWith(Camera::Source::kVideo, "v.avi", scratch));
  int count = 0;
  while (const auto frame = source->Next({})) {
    EXPECT_EQ(frame->image.size(), cv::Size(64, 48));
    EXPECT_NEAR(frame->image.at<cv::Vec3b>(24, 32)[1], 20 * count, 4) << "JPEG of a flat image";
    ++count;
  }
  EXPECT_EQ(count, 12);
}

TEST_F(FrameSourceTest, WhatCannotBeOpenedIsNamed) {
  EXPECT_THAT(OpeningMessage(SceneWith(Camera::Source::kFiles, "*.png", scratch)),
              testing::HasSubstr("no image matches"));
  scratch.Write("bad0.png", "no image");
  EXPECT_THAT(OpeningMessage(SceneWith(Camera::Source::kFiles, "bad%d.png", scratch)),
              testing::HasSubstr("bad0.png: image 1"));
  EXPECT_THAT(OpeningMessage(SceneWith(Camera::Source::kVideo, "none.avi", scratch)),
              testing::HasSubstr("none.avi: no such video"));
  scratch.Write("bad.avi", "no video");
  EXPECT_THAT(OpeningMessage(SceneWith(Camera::Source::kVideo, "bad.avi", scratch)),
              testing::HasSubstr("bad.avi: not a video"));
  Scene scene = SceneWith(Camera::Source::kDevice, "", scratch);
  scene.sense.Find<Camera>()->device = 63;
  EXPECT_THAT(OpeningMessage(scene), testing::HasSubstr("camera 63: no such camera"));
  EXPECT_THAT(OpeningMessage(SceneWith(Camera::Source::kSimulated, "", scratch)),
              testing::HasSubstr("opened by the simulator"));
  scene.sense = {};
  EXPECT_THAT(OpeningMessage(scene), testing::HasSubstr("has no camera"));
}

}  // namespace
}  // namespace palpate
