#include "slave/recording/recorded_samples.h"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "slave/recording/scene_files.h"
#include "slave/recording/sense_recording.h"
#include "slave/recording/step_messages.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

constexpr Time kBegin{std::chrono::nanoseconds(1'700'000'000'123'456'789)};

cv::Mat NoiseImage(int type, unsigned seed) {
  cv::Mat image(12, 17, type);
  std::mt19937 random(seed);
  for (std::size_t i = 0; i < image.total() * image.elemSize(); ++i) {
    image.data[i] = static_cast<unsigned char>(random());
  }
  return image;
}

bool IsSame(const cv::Mat& a, const cv::Mat& b) {
  return a.type() == b.type() && a.size() == b.size() &&
         std::equal(a.data, a.data + a.total() * a.elemSize(), b.data);
}

class RecordedSamplesTest : public FolderTest {
 protected:
  const std::filesystem::path file_ = folder_ / "a.mcap";
  const Scene scene_ = LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"));
};

TEST_F(RecordedSamplesTest, ImagesOfEveryKindComeBackPixelForPixel) {
  const std::vector<int> types{CV_8UC1, CV_8UC3, CV_16UC1, CV_16UC3};
  {
    SenseRecording recording(scene_, {}, {.file = file_});
    recording.Begin();
    recording.Opened();
    for (std::size_t i = 0; i < types.size(); ++i) {
      recording.OnSample(Frame{NoiseImage(types[i], static_cast<unsigned>(i)), i + 1,
                               kBegin + std::chrono::seconds(i)});
    }
    recording.Finish();
  }
  RecordedSamples samples(file_);
  const auto source = samples.OpenFrames();
  for (std::size_t i = 0; i < types.size(); ++i) {
    const auto frame = source->Next({});
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->sequence, i + 1);
    EXPECT_EQ(frame->sensed_at, kBegin + std::chrono::seconds(i));
    EXPECT_TRUE(IsSame(frame->image, NoiseImage(types[i], static_cast<unsigned>(i))));
  }
  EXPECT_FALSE(source->Next({}));
}

TEST_F(RecordedSamplesTest, PairsAndDepthComeBackTogether) {
  StereoPair pair, depth;
  pair.left = NoiseImage(CV_8UC1, 1);
  pair.right = NoiseImage(CV_8UC1, 2);
  pair.sequence = 1;
  pair.sensed_at = kBegin;
  pair.skew = -0.003;
  depth.left = NoiseImage(CV_16UC1, 3);
  depth.sequence = 2;
  depth.sensed_at = kBegin + Seconds(1);
  {
    SenseRecording recording(scene_, {}, {.file = file_});
    recording.Begin();
    recording.OnSample(pair);
    recording.OnSample(depth);
    recording.Finish();
  }
  RecordedSamples samples(file_);
  const auto source = samples.OpenPairs();
  const auto first = source->Next({}), second = source->Next({});
  ASSERT_TRUE(first && second);
  EXPECT_TRUE(IsSame(first->left, pair.left));
  EXPECT_TRUE(IsSame(first->right, pair.right));
  EXPECT_EQ(first->skew, pair.skew);
  EXPECT_TRUE(IsSame(second->left, depth.left));
  EXPECT_TRUE(second->right.empty());
}

TEST(TactileMessageTest, WhatIsNoSampleIsRefused) {
  v1::TactileInstant message;
  ToProto(TactileFrame{}, &message);
  EXPECT_NO_THROW(FromProto(message));
  auto longer = message;
  longer.add_fingers();
  EXPECT_THROW(FromProto(longer), InputError);
  auto shorter = message;
  shorter.mutable_fingers(0)->clear_electrodes();
  EXPECT_THROW(FromProto(shorter), InputError);
  auto unknown = message;
  unknown.mutable_fingers(0)->set_electrodes(3, std::nanf(""));
  EXPECT_THROW(FromProto(unknown), InputError);
  auto posed = message;
  posed.mutable_fingers(0)->add_pose(1);
  EXPECT_THROW(FromProto(posed), InputError);
}

TEST_F(RecordedSamplesTest, TheSceneAndItsFilesTravelAndLoadElsewhere) {
  const Scene cube = LoadScene(SourcePath("/deploy/scenes/foam-cube.yaml"));
  { SenseRecording(cube, {}, {.file = file_}).Begin(); }
  const RecordedBeginning beginning(file_);
  const auto scene = UnpackSceneFiles(beginning.files, folder_ / "scene");
  const Scene again = LoadScene(scene);
  EXPECT_EQ(again.name, cube.name);
  const auto before = InputFilesOf(cube), now = InputFilesOf(again);
  ASSERT_EQ(now.size(), before.size());
  int travelled = 0;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const bool was_there = std::filesystem::exists(before[i]);
    EXPECT_EQ(std::filesystem::exists(now[i]), was_there) << now[i];
    travelled += was_there ? 1 : 0;
  }
  EXPECT_GT(travelled, 1);
}

TEST_F(RecordedSamplesTest, AFileThatWouldLeaveItsFolderIsRefused) {
  for (const char* name : {"../a.yaml", "/etc/a.yaml", "b/../../a.yaml", ""}) {
    SceneFiles files;
    files.scene = name;
    files.bytes[name] = "name: a";
    EXPECT_THROW(UnpackSceneFiles(files, folder_ / "scene"), InputError) << name;
  }
}

}  // namespace
}  // namespace palpate
