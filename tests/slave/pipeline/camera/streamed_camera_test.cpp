// The shipped block with images from a driver: missing and unusable images are reported, good ones
// are estimated.
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/capture/codecs/codecs.h"
#include "slave/capture/image_inbox.h"
#include "slave/live/live_slave.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "tests/support/eventually.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using testing::Contains;
using testing::HasSubstr;

Scene StreamedBlock(const std::vector<std::string>& overrides) {
  return LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), overrides);
}

class StreamedCameraTest : public testing::Test {
 protected:
  void Feed(const cv::Mat& image) {
    const std::string data = EncodePng(image);
    PushedSample sample;
    sample.sensed_at = Clock::now();
    sample.image = {PushedImage::Encoding::kPng, &data};
    const auto refusal = slave_->image_inbox()->Feed(sample, Clock::now(), 1);
    EXPECT_FALSE(refusal) << refusal->why;
  }

  const Scene scene_ = StreamedBlock({"model.elements=60"});
  const std::unique_ptr<SimulatedEnvironment> environment_ = MakeSimulatedEnvironment(scene_);
  const std::unique_ptr<FrameSource> camera_ = environment_->OpenCamera(scene_, {});
  const std::unique_ptr<Slave> slave_ = MakeLiveSlave(StreamedBlock(
      {"model.elements=60", "sense.camera.source=stream", "manipulator.source=stream"}));
};

TEST_F(StreamedCameraTest, ReportsWhatItWaitsForUntilTheFirstUsableImage) {
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

}  // namespace
}  // namespace palpate
