// What `check` says of two cameras, simulated and from files.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"
#include "slave/commands/check/check.h"
#include "slave/scene/scene_loader.h"
#include "slave/simulator/points/stereo_site.h"
#include "slave/vision/stereo/pair_rig.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kScenes = SourcePath("/deploy/scenes");

std::string Said(const std::filesystem::path& scene,
                 const std::vector<std::string>& overrides = {}) {
  ::testing::internal::CaptureStdout();
  std::string error;
  try {
    RunCheck({scene, overrides});
  } catch (const std::exception& e) {
    error = e.what();
  }
  return ::testing::internal::GetCapturedStdout() + error;
}

// Reference: the stated rig: z^2 / (f b) sqrt(2) 0.03 px = 56 um at 250 mm, and all 31 dots in
// view.
TEST(CheckStereoTest, TheMembranesEyesAreTold) {
  const std::string said = Said(kScenes / "rubber-membrane.yaml");
  EXPECT_THAT(said, HasSubstr("plate-large: set by model.kind"));
  EXPECT_THAT(said, HasSubstr("simulated pair, 640 x 480 px, focal length 800 px, 60 mm apart"));
  EXPECT_THAT(
      said,
      HasSubstr(
          "250 mm from the object origin: with 0.03 px in the image a point has a sigma of 56"));
  EXPECT_THAT(said, HasSubstr("31 of 31 with radius 2 mm are visible to both cameras at rest"));
  EXPECT_THAT(said, HasSubstr("for an indentation of 5 mm below home"));
  EXPECT_THAT(
      said,
      HasSubstr(
          "31 of 31 points in the last of 15 images; the rest shape comes from the first 10"));
}

TEST(CheckStereoTest, ANarrowViewIsSaidToBeNarrow) {
  const std::string said =
      Said(kScenes / "rubber-membrane.yaml", {"sense.camera.pair.focal=2000 px"});
  EXPECT_THAT(
      said,
      HasSubstr("25 of 31 with radius 2 mm are visible to both cameras at rest: use a wider view"));
}

// 400 dots are 1.5 px in radius: too small to be found.
TEST(CheckStereoTest, DotsThatAreNotFoundAreSaidNotToBe) {
  EXPECT_THAT(Said(kScenes / "rubber-membrane.yaml", {"sense.points={count: 400}"}),
              HasSubstr("NOTHING yet: the rest shape needs 10 images of the untouched object; the "
                        "first 15 do not"));
}

TEST(CheckStereoTest, APressBeyondTheModelIsSaidToBe) {
  EXPECT_THAT(Said(kScenes / "rubber-membrane.yaml", {"operator.press.depth=19 mm"}),
              HasSubstr("below home, beyond the model's range"));
}

// A press within half the thickness is the closed form's, if the tolerance allows.
TEST(CheckStereoTest, AutoFollowsThePress) {
  const auto scene = kScenes / "rubber-membrane.yaml";
  EXPECT_THAT(Said(scene, {"model={kind: auto}"}),
              HasSubstr("model          plate-large: auto: plate-large"));
  EXPECT_THAT(
      Said(scene, {"model={kind: auto}", "operator.press.depth=0.2 mm"}),
      HasSubstr("model          plate: auto: plate, as in the scene: the cheapest that meets"));
}

TEST(CheckStereoTest, WhatMovesAsAWholeTellsNoForce) {
  const std::string said = Said(kScenes / "heart-target.yaml");
  EXPECT_THAT(said, HasSubstr("none: the object has no fixed boundary"));
  EXPECT_THAT(said, HasSubstr("up to 31 windows of 31 px"));
  EXPECT_THAT(said, Not(HasSubstr(" N for ")));
}

// Noise drowns the texture.
TEST(CheckStereoTest, WhatMayKeepWindowsFromBeingFoundIsNamed) {
  EXPECT_THAT(
      Said(kScenes / "heart-target.yaml", {"site.noise=150"}),
      AllOf(HasSubstr("needs one image of the untouched object"), HasSubstr("too little texture"),
            HasSubstr("the rig may be wrong"), HasSubstr("too near")));
}

// A path a thousand times as fast leaves most windows behind.
TEST(CheckStereoTest, FewWindowsAreSaidToBeFew) {
  EXPECT_THAT(
      Said(kScenes / "heart-target.yaml", {"site.pace=1000"}),
      AllOf(HasSubstr("FEW are in both images"), HasSubstr("or the images change too fast")));
  EXPECT_THAT(Said(kScenes / "heart-target.yaml"), Not(HasSubstr("FEW")));
}

// The simulated pair's pictures of the membrane at rest, as files.
class CheckFilesTest : public ::testing::Test {
 protected:
  CheckFilesTest() {
    const Scene scene = LoadScene(kScenes / "rubber-membrane.yaml");
    StereoSite site(scene);
    for (int i = 0; i < kPairs; ++i) {
      const StereoPictures pair = site.TakePictures();
      WriteWholeFile(folder_.path() / ("left" + std::to_string(i) + ".png"), EncodePng(pair.left));
      WriteWholeFile(folder_.path() / ("right" + std::to_string(i) + ".png"),
                     EncodePng(pair.right));
    }
    WriteRig(folder_.path() / "rig.yaml", site.rig());
    StereoRig other = site.rig();
    other.left.size = other.right.size = {320, 240};
    WriteRig(folder_.path() / "small.yaml", other);
    StereoRig wide = site.rig();
    wide.X_RL.translation() *= 1.5;
    WriteRig(folder_.path() / "wide.yaml", wide);
  }
  std::string SaidOfFiles(const std::string& right, const std::string& rig) const {
    return Said(folder_.Write(
        "scene.yaml",
        "name: files\nobject:\n  geometry: {membrane: {radius: 39 mm, thickness: 1 mm}}\n"
        "  material: {young_modulus: 27.2 MPa, poisson_ratio: 0.45}\nmodel: {kind: plate-large}\n"
        "sense:\n  camera:\n    stereo: {left: \"left*.png\", right: \"" +
            right + "\", rig: " + rig +
            "}\n    pose: {translation: [-30 mm, 0, -250 mm], rotation: [0, 6.8428 deg, 0]}\n"));
  }
  static constexpr int kPairs = 12;
  Scratch folder_;
};

TEST_F(CheckFilesTest, TheirDotsAreLookedFor) {
  const std::string said = SaidOfFiles("right*.png", "rig.yaml");
  EXPECT_THAT(said, HasSubstr("pair of image files, 640 x 480 px"));
  EXPECT_THAT(said, HasSubstr("(12 pairs)"));
  EXPECT_THAT(said, HasSubstr("31 of 31 points in the last of 12 images"));
}

TEST_F(CheckFilesTest, ARigOfOtherCamerasIsSuspected) {
  EXPECT_THAT(SaidOfFiles("right*.png", "wide.yaml"),
              AllOf(HasSubstr("NOTHING yet"), HasSubstr("check the sides (left, right), the rig")));
}

TEST_F(CheckFilesTest, ARigOfOtherPicturesIsRefused) {
  EXPECT_THAT(SaidOfFiles("right*.png", "small.yaml"),
              AllOf(HasSubstr("640 x 480"), HasSubstr("320 x 240")));
}

// What a laboratory looks for: which camera is which eye, when two pictures are a pair, the arm.
TEST_F(CheckFilesTest, WhatIsPluggedInIsNamed) {
  const auto said = [&](const std::string& eyes, const std::string& arm = "simulated") {
    return Said(folder_.Write(
        "scene.yaml",
        "name: plugged\nobject:\n  geometry: {membrane: {radius: 39 mm, thickness: 1 mm}}\n"
        "  material: {young_modulus: 27.2 MPa, poisson_ratio: 0.45}\nmodel: {kind: plate-large}\n"
        "sense:\n  camera:\n    stereo: {" +
            eyes +
            ", rig: rig.yaml}\n    pose: {translation: [-30 mm, 0, -250 mm], rotation: [0, 6.8428 "
            "deg, 0]}\nmanipulator: {source: " +
            arm + "}\n"));
  };
  EXPECT_THAT(said("left: {device: 90}, right: {device: 92}, sync: 8 ms"),
              AllOf(HasSubstr("left camera 90 (/dev/video90), right camera 92 (/dev/video92), 30 "
                              "Hz"),
                    HasSubstr("images that arrive more than 8 ms apart are not paired"),
                    HasSubstr("manipulator    simulated")));
  EXPECT_THAT(said("device: 90, layout: side-by-side"),
              AllOf(HasSubstr("camera 90 (/dev/video90), left and right side by side"),
                    Not(HasSubstr("not paired"))));
  EXPECT_THAT(said("left: {url: \"a ! appsink\"}, right: {url: \"udp://127.0.0.1:9\"}, sync: 1 "
                   "ms"),
              HasSubstr("left GStreamer pipeline a ! appsink, right stream udp://127.0.0.1:9"));
  const std::string pushed = said("source: stream", "stream, silence: 60 ms");
  EXPECT_THAT(
      pushed,
      AllOf(HasSubstr("image pairs from a driver (FeedImages), 30 Hz"),
            HasSubstr("are more than 5 ms apart are not paired"),
            HasSubstr("driven by a client (DriveTool); a fault is raised after 60 ms of silence")));
}

TEST(CheckCameraTest, WhatIsPluggedInIsNamed) {
  EXPECT_THAT(Said(kScenes / "silicone-block.yaml"),
              AllOf(HasSubstr("simulated, 640x480 px"), HasSubstr("manipulator    simulated")));
  EXPECT_THAT(Said(kScenes / "silicone-block.yaml",
                   {"sense.camera.source=stream", "manipulator.source=stream"}),
              AllOf(HasSubstr("images from a driver (FeedImages)"),
                    HasSubstr("driven by a client (DriveTool)"),
                    HasSubstr("image latency, from the manipulator")));
}

TEST_F(CheckFilesTest, UnequalNumbersOfPicturesAreCounted) {
  EXPECT_THAT(SaidOfFiles("right?.png", "rig.yaml"),
              AllOf(HasSubstr("has 12 images"), HasSubstr("has 10")));
}

}  // namespace
}  // namespace palpate
