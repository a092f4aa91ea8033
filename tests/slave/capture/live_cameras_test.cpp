// Tests cameras that run freely, freeze, are unplugged and return. Fake cameras replace those of
// OpenCV.
#include "slave/capture/live_cameras.h"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <sys/socket.h>
#include <unistd.h>

namespace palpate {
namespace {

using testing::HasSubstr;

// A camera whose images the test supplies, one grey level each.
class FakeCamera {
 public:
  void Show(int level) {
    const std::lock_guard lock(mutex_);
    shown_.push_back(level);
    changed_.notify_all();
  }
  void Unplug() { Show(kUnplugged); }
  void PlugIn() {
    const std::lock_guard lock(mutex_);
    is_there_ = true;
  }
  void set_size(const cv::Size& size) {
    const std::lock_guard lock(mutex_);
    size_ = size;
  }
  CameraInput Input(const std::string& name, int type = CV_8UC1) {
    return {name, [this, type] { return Open(type); }};
  }

 private:
  static constexpr int kUnplugged = -1;

  class Images final : public VideoStream {
   public:
    Images(FakeCamera& camera, int type) : camera_(camera), type_(type) {}
    cv::Mat Next() override {
      std::unique_lock lock(camera_.mutex_);
      // Only against a hanging test: a frozen camera times out.
      if (!camera_.changed_.wait_for(lock, std::chrono::seconds(20),
                                     [this] { return !camera_.shown_.empty(); })) {
        return {};
      }
      const int level = camera_.shown_.front();
      camera_.shown_.pop_front();
      if (level == kUnplugged) camera_.is_there_ = false;
      return level == kUnplugged ? cv::Mat()
                                 : cv::Mat(camera_.size_, type_, cv::Scalar::all(level));
    }

   private:
    FakeCamera& camera_;
    int type_;
  };

  std::unique_ptr<VideoStream> Open(int type) {
    const std::lock_guard lock(mutex_);
    return is_there_ ? std::make_unique<Images>(*this, type) : nullptr;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<int> shown_;
  bool is_there_ = true;
  cv::Size size_{6, 4};
};

// Ends the reader's wait before the cameras are destroyed.
class Ending {
 public:
  explicit Ending(std::vector<FakeCamera*> cameras) : cameras_(std::move(cameras)) {}
  ~Ending() {
    for (FakeCamera* camera : cameras_) camera->Unplug();
  }
  Ending(const Ending&) = delete;
  Ending& operator=(const Ending&) = delete;

 private:
  std::vector<FakeCamera*> cameras_;
};

int LevelOf(const cv::Mat& image) {
  return image.at<unsigned char>(0, 0);
}

// A server that accepts the connection and sends nothing: OpenCV alone would wait for 30 s.
TEST(LiveCamerasTest, AStreamThatDoesNotAnswerIsGivenUp) {
  const int listening = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in here{};
  here.sin_family = AF_INET;
  here.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(bind(listening, reinterpret_cast<sockaddr*>(&here), sizeof here), 0);
  ASSERT_EQ(listen(listening, 4), 0);
  socklen_t size = sizeof here;
  getsockname(listening, reinterpret_cast<sockaddr*>(&here), &size);
  const auto began = std::chrono::steady_clock::now();
  const auto video = LoadVideoBackend().OpenUrl(
      "http://127.0.0.1:" + std::to_string(ntohs(here.sin_port)) + "/eye.mjpg",
      std::chrono::milliseconds(300));
  EXPECT_EQ(video, nullptr);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(20));
  close(listening);
}

// Behaves like a GStreamer pipeline whose source sends nothing.
TEST(LiveCamerasTest, ACameraWhoseOpeningNeverEndsIsReported) {
  auto held = std::make_shared<std::promise<void>>();
  const CameraInput mute{"stream of nobody", [held] {
                           held->get_future().wait();
                           return std::unique_ptr<VideoStream>();
                         }};
  EXPECT_THAT(
      [&] { LiveCameras({mute}, PairLayout::kOneCamera, 0, std::chrono::milliseconds(10)); },
      testing::ThrowsMessage<std::runtime_error>(
          HasSubstr("stream of nobody: no answer within 0.01 s")));
  held->set_value();
}

TEST(LiveCamerasTest, AnUnpluggedCameraReturnsByItself) {
  FakeCamera camera;
  const auto source = FramesOf({camera.Input("camera 0")}, {});
  const Ending ending({&camera});
  camera.Show(1);
  ASSERT_TRUE(source->Next({}));
  camera.Unplug();
  while (source->health()->trouble.empty()) std::this_thread::yield();
  EXPECT_THAT(source->health()->trouble, HasSubstr("camera 0: disconnected; reconnecting"));
  camera.PlugIn();
  camera.Show(2);
  EXPECT_EQ(LevelOf(source->Next({})->image), 2);
  EXPECT_EQ(source->health()->trouble, "");
}

TEST(LiveCamerasTest, ImagesOfAnotherSizeThanTheScenesAreRefusedAtOnce) {
  FakeCamera camera;
  CameraInput input = camera.Input("camera 0");
  input.size = {640, 480};  // the driver may choose another size
  const auto source = FramesOf({input}, {});
  const Ending ending({&camera});
  camera.Show(1);
  EXPECT_THAT([&] { source->Next({}); },
              testing::ThrowsMessage<std::runtime_error>(
                  HasSubstr("camera 0: 6 x 4 px: expected 640 x 480 px, the size in the scene")));
}

TEST(LiveCamerasTest, ImagesOfAnotherSizeAreDroppedAndReported) {
  FakeCamera camera;
  const auto source = FramesOf({camera.Input("camera 0")}, {});
  const Ending ending({&camera});
  camera.Show(1);
  ASSERT_TRUE(source->Next({}));
  camera.set_size({8, 4});
  camera.Show(2);
  while (source->health()->trouble.empty()) std::this_thread::yield();
  EXPECT_THAT(source->health()->trouble,
              HasSubstr("camera 0: 8 x 4 px, 1 channel of 8 bit: expected the format of the "
                        "first image, 6 x 4 px, 1 channel of 8 bit"));
  camera.set_size({6, 4});
  camera.Show(3);
  EXPECT_EQ(LevelOf(source->Next({})->image), 3);
  EXPECT_EQ(source->health()->trouble, "");
}

TEST(LiveCamerasTest, ImagesOfTheSameTimeAreAPair) {
  FakeCamera left, right;
  const auto source =
      PairsOf({left.Input("camera 0"), right.Input("camera 2")}, PairLayout::kTwoCameras, 1e6);
  const Ending ending({&left, &right});
  left.Show(1);
  right.Show(2);
  const auto pair = source->Next({});
  EXPECT_EQ(LevelOf(pair->left), 1);
  EXPECT_EQ(LevelOf(pair->right), 2);
  EXPECT_NE(pair->skew, 0);
  EXPECT_EQ(pair->skew, source->health()->skew);
}

// No two images come within a nanosecond of each other: all are dropped and counted.
TEST(LiveCamerasTest, ImagesThatComeTooFarApartAreNoPairAndAreCounted) {
  FakeCamera left, right;
  const auto source =
      PairsOf({left.Input("camera 0"), right.Input("camera 2")}, PairLayout::kTwoCameras, 1e-9);
  const Ending ending({&left, &right});
  left.Show(1);
  right.Show(2);
  while (source->health()->dropped == 0) std::this_thread::yield();
  EXPECT_EQ(source->health()->taken, 0U);
}

TEST(LiveCamerasTest, SideBySideIsCutInTwo) {
  const auto layout = PairLayout::kSideBySide;
  cv::Mat both(4, 6, CV_8UC1, cv::Scalar(1));
  both.colRange(3, 6).setTo(2);
  const StereoPair pair = Arranged({.left = both}, layout, "camera 0");
  EXPECT_EQ(pair.left.size(), cv::Size(3, 4));
  EXPECT_EQ(LevelOf(pair.left), 1);
  EXPECT_EQ(LevelOf(pair.right), 2);
  EXPECT_THAT(
      [&] { Arranged({.left = both.colRange(0, 5)}, layout, "camera 0"); },
      testing::ThrowsMessage<std::runtime_error>(HasSubstr("5 px wide: side by side, expected")));
}

}  // namespace
}  // namespace palpate
