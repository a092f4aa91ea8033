// The shipped block with images that a driver sends: what is missing is reported, what cannot be
// used is reported, what comes is estimated.
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/picture_inbox.h"
#include "slave/live/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/simulator/environment_player.h"
#include "tests/support/eventually.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using testing::Contains;
using testing::HasSubstr;

const std::string& Block() {
  static const std::string file = SourcePath("/deploy/scenes/silicone-block.yaml");
  return file;
}

Scene Streamed() {
  return LoadScene(
      Block(), {"model.elements=60", "sense.camera.source=stream", "manipulator.source=stream"});
}

class StreamedCameraTest : public testing::Test {
 protected:
  void Feed(const cv::Mat& picture) { Feed(picture, *slave_->picture_inbox()); }
  static void Feed(const cv::Mat& picture, PictureInbox& inbox) {
    const std::string data(reinterpret_cast<const char*>(picture.data),
                           picture.total() * picture.elemSize());
    PushedSample sample;
    sample.sensed_at = Clock::now();
    sample.picture = {
        picture.channels() == 3 ? PushedPicture::Encoding::kBgr8 : PushedPicture::Encoding::kGrey8,
        &data, static_cast<unsigned>(picture.cols), static_cast<unsigned>(picture.rows)};
    const auto refusal = inbox.Feed(sample, Clock::now(), 1);
    EXPECT_FALSE(refusal) << refusal->why;
  }

  const Scene scene_ = LoadScene(Block(), {"model.elements=60"});
  const std::unique_ptr<SimulatedEnvironment> environment_ = MakeSimulatedEnvironment(scene_);
  const std::unique_ptr<FrameSource> camera_ = environment_->OpenCamera(scene_, {});
  const std::unique_ptr<Slave> slave_ = MakeLiveSlave(Streamed());
};

TEST_F(StreamedCameraTest, SaysWhatItWaitsForAndIsMadeOfTheFirstPictureThatWillDo) {
  EXPECT_THAT(slave_->Status().alarms, Contains(HasSubstr("no image received yet")));
  EXPECT_THAT(slave_->Status().alarms,
              Contains(HasSubstr("no driver of the manipulator is connected")));
  EXPECT_FALSE(slave_->Compose(Clock::now()).force);
  EXPECT_EQ(slave_->Compose(Clock::now()).check, FailedCheck::kArmFault);
  EXPECT_THROW(slave_->SetParameters({.young_modulus = 1e5}), std::logic_error);
  const auto revision = slave_->Describe().settings_revision;

  const cv::Mat first = camera_->Next({})->image;
  Feed(cv::Mat(first.size(), first.type(), cv::Scalar::all(128)));
  ASSERT_TRUE(Eventually([&] {
    return slave_->Status().cameras->trouble.find("cannot be used: ") != std::string::npos;
  })) << slave_->Status().cameras->trouble;

  Feed(first);
  ASSERT_TRUE(Eventually([&] { return slave_->Status().cameras->trouble.empty(); }));
  ASSERT_TRUE(Eventually([&] { return slave_->Compose(Clock::now()).force.has_value(); }));
  EXPECT_GT(slave_->Describe().settings_revision, revision) << "the master reads the scene anew";
  EXPECT_EQ(slave_->Describe().sense.model.kind, "bem2d");
}

// Without the model's patch the master renders a plane whose normal is that of the first contact.
TEST_F(StreamedCameraTest, AStreamedImageGivesTheSamePatchAsTheSameSimulatedOne) {
  EnvironmentPlayer player(*environment_, scene_, {});
  const auto simulated = MakeSensingPipeline(scene_, {.player = &player});
  const auto streamed = MakeSensingPipeline(Streamed(), {.is_live = true});
  ASSERT_TRUE(simulated->Acquire({}));
  simulated->Estimate(scene_.manipulator.home);
  Feed(simulated->Picture(0)->plain, *streamed->pictures());
  ASSERT_TRUE(streamed->Acquire({}));
  streamed->Estimate(scene_.manipulator.home);
  SurfacePatch expected, patch;
  ASSERT_TRUE(simulated->MakePatch(scene_.manipulator.home, &expected));
  ASSERT_TRUE(streamed->MakePatch(scene_.manipulator.home, &patch));
  ASSERT_EQ(patch.vertex_count, expected.vertex_count);
  // Tolerance: a hundredth of a pixel of 0.35 mm, by which the two images may differ in depth.
  for (int i = 0; i < expected.vertex_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_LT((patch.vertices[k] - expected.vertices[k]).norm(), 3.5e-6F) << i;
  }
}

}  // namespace
}  // namespace palpate
