// The shipped block with pictures that somebody pushes and an arm that somebody drives: what is
// missing is reported, what will not do is reported, what comes is estimated.
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
  Scene scene = LoadScene(
      Block(), {"model.elements=60", "sense.camera.source=stream", "manipulator.source=stream"});
  scene.manipulator.silence = 60;  // a busy machine is no silent driver
  return scene;
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
  void Report(double y) {
    ArmReading reading;
    reading.sequence = ++reports_;
    reading.measured_at = Clock::now();
    reading.p_S_tip = scene_.manipulator.home + Eigen::Vector3d(0, y, 0);
    reading.force = Eigen::Vector3d(0, 0.5, 0);
    EXPECT_EQ(slave_->driven_arm()->Take(1, "a driver", reading, Clock::now()), std::nullopt);
  }

  const Scene scene_ = LoadScene(Block(), {"model.elements=60"});
  const std::unique_ptr<SimulatedEnvironment> environment_ = MakeSimulatedEnvironment(scene_);
  const std::unique_ptr<FrameSource> camera_ = environment_->OpenCamera(scene_, {});
  const std::unique_ptr<Slave> slave_ = MakeLiveSlave(Streamed());
  std::uint64_t reports_ = 0;
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

TEST_F(StreamedCameraTest, AMeasuredForceIsReportedAsTheTrueOneAndNeverEstimatedFrom) {
  Feed(camera_->Next({})->image);
  ASSERT_TRUE(Eventually([&] {
    Report(0);
    return slave_->Compose(Clock::now()).true_force.has_value();
  }));
  EXPECT_EQ(slave_->Compose(Clock::now()).true_force, Eigen::Vector3d(0, 0.5, 0));
  ASSERT_TRUE(Eventually([&] { return slave_->Compose(Clock::now()).force.has_value(); }));
  EXPECT_TRUE(slave_->Compose(Clock::now()).force->isZero());
}

TEST_F(StreamedCameraTest, APressByAStreamedArmGoesThroughTheSameGuards) {
  OperatorCommand command;
  command.epoch = 1;
  command.engaged = true;
  slave_->BeginOperating();
  const auto send = [&](double y) {
    ++command.sequence;
    command.p_M = {0, y, 0};
    return slave_->Command(command);
  };
  EXPECT_TRUE(send(0));
  EXPECT_EQ(slave_->Compose(Clock::now()).phase, Phase::kHold) << "no driver of the manipulator";
  ASSERT_TRUE(Eventually([&] {
    Report(0);
    return slave_->Compose(Clock::now()).check != FailedCheck::kArmFault;
  }));
  EXPECT_TRUE(send(0));
  EXPECT_EQ(slave_->Compose(Clock::now()).phase, Phase::kHold) << "not without an engagement";
  command.epoch = 2;
  Report(0);
  EXPECT_TRUE(send(0));
  EXPECT_FALSE(send(-0.05)) << "a leap beyond the arm";
  slave_->EndOperating();
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
