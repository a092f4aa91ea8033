// Depth cameras of OpenNI2: the module palpate-openni itself, over a fake library in the place of
// the real one.
#include <memory>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "slave/capture/live_cameras.h"
#include "tests/slave/capture/fake_openni.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class DepthCameraTest : public testing::Test {
 protected:
  DepthCameraTest() { TheFakeOpenNi() = {}; }
  static std::unique_ptr<StereoSource> Open(double unit = 1e-3) {
    const Eye eye{Eye::Kind::kOpenNi, 0, {}};
    return PairsOf({InputOf(eye, {}, 30, unit)}, PairLayout::kDepth, 0);
  }
  static std::vector<std::uint16_t> FirstRow(StereoSource& source) {
    const cv::Mat picture = source.Next({})->left;
    return {picture.ptr<std::uint16_t>(), picture.ptr<std::uint16_t>() + picture.cols};
  }
};

TEST_F(DepthCameraTest, ItsPicturesAreNoMirrorsView) {
  for (const bool can_unmirror : {true, false}) {
    TheFakeOpenNi().can_unmirror = can_unmirror;
    EXPECT_THAT(FirstRow(*Open()), ElementsAre(1, 2, 3, 4)) << can_unmirror;
  }
}

TEST_F(DepthCameraTest, WhatIsNotThereOrMeasuresNoDepthIsReported) {
  const auto is_reported = testing::ThrowsMessage<std::runtime_error>(
      HasSubstr("OpenNI2 depth camera 0: no such camera or stream, no permission"));
  TheFakeOpenNi().cameras = 0;
  EXPECT_THAT([] { Open(); }, is_reported);
  TheFakeOpenNi() = {.has_depth = false};
  EXPECT_THAT([] { Open(); }, is_reported);
  TheFakeOpenNi() = {.unit = 0};
  EXPECT_THAT([] { Open(); }, is_reported);
}

TEST_F(DepthCameraTest, AnotherUnitThanTheScenesIsRefused) {
  TheFakeOpenNi().unit = 1e-4;
  EXPECT_THAT([] { Open(1e-3); },
              testing::ThrowsMessage<std::runtime_error>(
                  HasSubstr("one count is 0.1 mm: expected the value of sense.camera.unit, 1 mm")));
  EXPECT_NO_THROW(Open(1e-4));
}

}  // namespace
}  // namespace palpate
