// Tests the report of `check` about two cameras, simulated and from files.
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
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::filesystem::path kStereoScenes = SourcePath("/deploy/scenes");

std::string OutputOf(const std::filesystem::path& scene,
                     const std::vector<std::string>& overrides = {}) {
  ::testing::internal::CaptureStdout();
  const std::string error = Thrown<std::exception>([&] { RunCheck({scene, overrides}); });
  return ::testing::internal::GetCapturedStdout() + error;
}

// Reference: the stated rig: z^2 / (f b) sqrt(2) 0.03 px = 56 um at 250 mm, and all 31 dots in
// view.
TEST(CheckStereoTest, TheMembranesCamerasAreReported) {
  const std::string output = OutputOf(kStereoScenes / "rubber-membrane.yaml");
  EXPECT_THAT(output, HasSubstr("plate-large: set by model.kind"));
  EXPECT_THAT(output, HasSubstr("simulated pair, 640 x 480 px, focal length 800 px, 60 mm apart"));
  EXPECT_THAT(
      output,
      HasSubstr(
          "250 mm from the object origin: with 0.03 px in the image a point has a sigma of 56"));
  EXPECT_THAT(output, HasSubstr("31 of 31 with radius 2 mm are visible to both cameras at rest"));
  EXPECT_THAT(output, HasSubstr("for an indentation of 5 mm below home"));
  EXPECT_THAT(
      output,
      HasSubstr(
          "31 of 31 points in the last of 15 images; the rest shape comes from the first 10"));
}

// For a press within half the thickness `auto` chooses the closed form, if the tolerance permits.
TEST(CheckStereoTest, AutoFollowsThePress) {
  const auto scene = kStereoScenes / "rubber-membrane.yaml";
  EXPECT_THAT(
      OutputOf(scene, {"model={kind: auto}"}),
      HasSubstr("model          plate-large: auto: membrane: an indentation of 5 thicknesses"));
  EXPECT_THAT(OutputOf(scene, {"model={kind: auto}", "operator.press.depth=0.2 mm"}),
              HasSubstr("model          plate: auto: membrane: an indentation of 0.2 thicknesses"));
}

TEST(CheckStereoTest, ARigidlyMovingTargetHasNoForce) {
  const std::string output = OutputOf(kStereoScenes / "heart-target.yaml");
  EXPECT_THAT(output, HasSubstr("none: the object has no fixed boundary"));
  EXPECT_THAT(output, HasSubstr("up to 31 windows of 31 px"));
  EXPECT_THAT(output, Not(HasSubstr(" N for ")));
}

// The simulated pair's images of the membrane at rest, as files.
class CheckFilesTest : public ::testing::Test {
 protected:
  CheckFilesTest() {
    const Scene scene = LoadScene(kStereoScenes / "rubber-membrane.yaml");
    StereoSite site(scene);
    for (int i = 0; i < kPairs; ++i) {
      const StereoImages pair = site.TakeImages();
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
  std::string OutputOfFiles(const std::string& right, const std::string& rig) const {
    return OutputOf(folder_.Write(
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
  const std::string output = OutputOfFiles("right*.png", "rig.yaml");
  EXPECT_THAT(output, HasSubstr("pair of image files, 640 x 480 px"));
  EXPECT_THAT(output, HasSubstr("(12 pairs)"));
  EXPECT_THAT(output, HasSubstr("31 of 31 points in the last of 12 images"));
}

TEST_F(CheckFilesTest, ARigOfOtherCamerasIsSuspected) {
  EXPECT_THAT(OutputOfFiles("right*.png", "wide.yaml"),
              AllOf(HasSubstr("NOTHING yet"), HasSubstr("check the sides (left, right), the rig")));
}

}  // namespace
}  // namespace palpate
