// `palpate-slave calibrate` as a user calls it, on real chessboards.
#include "slave/commands/calibrate/calibrate.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "slave/vision/stereo/rig.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class CalibrateTest : public FolderTest {
 protected:
  CalibrateTest() { options_.out = folder_ / "rig.yaml"; }

  // Standard output and error go to output_.
  int Run() {
    output_.clear();
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    int code = -1;
    try {
      code = RunCalibrate(options_, {});
    } catch (const std::invalid_argument& error) {
      output_ = error.what();
      code = 2;
    } catch (const std::runtime_error& error) {
      output_ = error.what();
      code = 1;
    }
    output_ += testing::internal::GetCapturedStdout() + testing::internal::GetCapturedStderr();
    return code;
  }
  [[nodiscard]] int Occurrences(const std::string& words) const {
    int count = 0;
    for (auto at = output_.find(words); at != std::string::npos; at = output_.find(words, at + 1)) {
      ++count;
    }
    return count;
  }
  void Chessboards(const fs::path& left, const fs::path& right) {
    options_.left = left, options_.right = right;
    options_.board = {9, 6}, options_.square = "25mm";
  }
  const fs::path data_ = SourcePath("/../shared/data");
  const fs::path chess_ = data_ / "stereo_chessboard_opencv";
  CalibrateOptions options_;
  std::string output_;
};

// The shipped block with `lines` as its camera's.
Scene BlockWithCamera(const std::vector<std::string>& lines) {
  std::vector<std::string> overrides;
  for (const std::string& line : lines) {
    const auto colon = line.find(": ");
    overrides.push_back("sense.camera." + line.substr(0, colon) + "=" + line.substr(colon + 2));
  }
  return LoadScene(SourcePath("/deploy/scenes/silicone-block.yaml"), overrides);
}

std::vector<std::string> LinesOf(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream stream(file);
  for (std::string line; std::getline(stream, line);) {
    if (line.front() != '#') lines.push_back(line);
  }
  return lines;
}

// Reference: the baseline and focal lengths that the data's README states for its own calibration
// of the same pairs (0.0832 m, 533.2 and 537.5 px); free choices of model move them by 0.3 %.
TEST_F(CalibrateTest, ARealPairFitsWithinAThirdOfAPixelAndStatesItsRepeatability) {
  if (!fs::exists(chess_)) GTEST_SKIP() << "../shared is absent";
  Chessboards(chess_ / "left*.jpg", chess_ / "right*.jpg");
  ASSERT_EQ(Run(), 0) << output_;
  const StereoRig rig = ReadRig(options_.out);
  EXPECT_LE(rig.rms_px, 0.3);
  EXPECT_NEAR(rig.baseline(), 0.0832, 0.003 * 0.0832);
  EXPECT_NEAR(rig.left.fx, 533.2, 2);
  EXPECT_NEAR(rig.right.fx, 537.5, 2);
  EXPECT_GT(rig.X_RL.inverse().translation().x(), 0.08);
  EXPECT_THAT(output_,
              HasSubstr("one sigma of the baseline, from fits without one of them each: 0."));
}

TEST_F(CalibrateTest, FitsThatDisagreeAreRefusedHoweverSmallTheResidual) {
  const fs::path endoscope = data_ / "stereo_endoscope_dvrk";
  if (!fs::exists(endoscope)) GTEST_SKIP() << "../shared is absent";
  options_.left = endoscope / "chess_left*.png", options_.right = endoscope / "chess_right*.png";
  options_.board = {6, 9}, options_.square = "11.66 mm";
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("rejected: the baseline has a sigma of"));
  EXPECT_FALSE(fs::exists(options_.out));
}

// The sides are exchanged in the images, and the board's counts in the options.
TEST_F(CalibrateTest, ExchangedSidesAreRefused) {
  if (!fs::exists(chess_)) GTEST_SKIP() << "../shared is absent";
  Chessboards(chess_ / "right*.jpg", chess_ / "left*.jpg");
  options_.board = {6, 9};
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("rejected: left and right are exchanged"));
  EXPECT_FALSE(fs::exists(options_.out));
}

// There are one pair whose right image was taken at another time, one file that is no image, one
// image without a board, one without a partner and one file without a number. The remaining pairs
// give exactly the same rig as they give alone.
TEST_F(CalibrateTest, WhatIsBadIsNamedAndLeftOut) {
  if (!fs::exists(chess_)) GTEST_SKIP() << "../shared is absent";
  const fs::path alone = folder_ / "alone";
  fs::create_directories(alone);
  for (int i = 1; i <= 9; ++i) {
    const std::string number = "0" + std::to_string(i) + ".jpg";
    fs::copy(chess_ / ("left" + number), folder_ / ("left" + number));
    if (i != 5) fs::copy(chess_ / ("right" + number), folder_ / ("right" + number));
    if (i == 2 || i == 5 || i == 7 || i == 8) continue;
    fs::copy(chess_ / ("left" + number), alone / ("left" + number));
    fs::copy(chess_ / ("right" + number), alone / ("right" + number));
  }
  fs::copy(chess_ / "right06.jpg", folder_ / "right02.jpg", fs::copy_options::overwrite_existing);
  Write("right07.jpg", "not an image");
  Write("left_notes.jpg", "not an image");
  fs::copy(data_ / "stereo_endoscope_dvrk" / "scene_cap_left.png", folder_ / "left08.jpg",
           fs::copy_options::overwrite_existing);
  Chessboards(alone / "left*.jpg", alone / "right*.jpg");
  ASSERT_EQ(Run(), 0) << output_;
  const StereoRig expected = ReadRig(options_.out);
  Chessboards(folder_ / "left*.jpg", folder_ / "right*.jpg");
  ASSERT_EQ(Run(), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("pair 2: not used: deviates by"));
  EXPECT_THAT(output_, HasSubstr("right07.jpg: not used: "));
  EXPECT_THAT(output_, HasSubstr("left08.jpg: not used: the board is not completely visible"));
  EXPECT_THAT(output_, HasSubstr("left_notes.jpg: not used: "));
  for (const char* pair : {"pair 5", "pair 7"}) {
    EXPECT_THAT(output_, HasSubstr(std::string(pair) + ": not used: only the left image"));
  }
  EXPECT_EQ(Occurrences("not used"), 6) << output_;
  const StereoRig found = ReadRig(options_.out);
  EXPECT_EQ(found.X_RL.matrix(), expected.X_RL.matrix()) << output_;
  EXPECT_NEAR(found.baseline(), 0.0832, 0.01 * 0.0832);
}

TEST_F(CalibrateTest, OneCameraGivesALens) {
  if (!fs::exists(chess_)) GTEST_SKIP() << "../shared is absent";
  Chessboards(chess_ / "left*.jpg", "");
  options_.square = "0.025";
  ASSERT_EQ(Run(), 0) << output_;
  const StereoRig rig = ReadRig(options_.out);
  EXPECT_EQ(rig.baseline(), 0);
  EXPECT_NEAR(rig.left.fx, 533.2, 2);
  EXPECT_LE(rig.rms_px, 0.25);
  options_.left = chess_ / "left01.jpg";
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("1 images or pairs show the board: expected 3 or more"));
}

TEST_F(CalibrateTest, SaysWhatItCannotUse) {
  EXPECT_EQ(Run(), 2);
  EXPECT_THAT(output_, HasSubstr("expected --left or --register"));
  for (const char* square : {"-1mm", "25 kPa"}) {
    Chessboards("none*.jpg", "");
    options_.square = square;
    EXPECT_EQ(Run(), 2) << square;
    EXPECT_THAT(output_, HasSubstr("--square"));
  }
  Chessboards("none*.jpg", "");
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("none*.jpg"));
  if (!fs::exists(chess_)) GTEST_SKIP() << "../shared is absent";
  Chessboards(chess_ / "left0?.jpg", chess_ / "right01.jpg");
  EXPECT_EQ(Run(), 1) << "one pair is too few";
  Chessboards(chess_ / "left01.jpg", "");
  options_.board = {10, 7};
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("--board counts the inner corners of a chessboard"));
}

// Positions on the plane z = 0, seen through a lens by a camera 0.4 m above it; the sixth is wrong.
std::string PlacesThroughALens(const Lens& lens, const Eigen::Isometry3d& X_SC) {
  std::string rows = "x,y,z,u,v\n";
  int number = 0;
  for (const double x : {-0.06, 0.0, 0.07}) {
    for (const double y : {-0.05, 0.01, 0.04}) {
      const Eigen::Vector2d at = *Project(lens, X_SC.inverse() * Eigen::Vector3d(x, y, 0));
      const double off = ++number == 6 ? 0.01 : 0;
      char row[128];
      std::snprintf(row, sizeof row, "%.17g,%.17g,0,%.17g,%.17g\n", x + off, y, at.x(), at.y());
      rows += row;
    }
  }
  return rows;
}

// Reference: the lens that saw the places: Z / f per pixel, the image's centre where the straight
// image's centre looks, up in the image against y of the camera.
TEST_F(CalibrateTest, RegistersACameraWithALensAboveThePlane) {
  StereoRig camera;
  camera.left = {800, 800, 322, 236, {-0.3, 0.1, 0, 0, 0}, {640, 480}};
  WriteRig(folder_ / "lens.yaml", camera);
  Eigen::Isometry3d X_SC = Eigen::Isometry3d::Identity();  // z forward: straight down
  X_SC.translation() = Eigen::Vector3d(0.01, -0.005, 0.4);
  X_SC.linear() = (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  options_.tip_places = Write("tips.csv", PlacesThroughALens(camera.left, X_SC));
  options_.rig = folder_ / "lens.yaml";
  options_.plane = true;
  options_.out = folder_ / "lines.yaml";
  ASSERT_EQ(Run(), 0) << output_;
  EXPECT_EQ(Occurrences("not used"), 1) << output_;
  auto lines = LinesOf(options_.out);
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_THAT(lines[0], testing::StartsWith("intrinsics: " + options_.rig.string()));
  const Scene scene = BlockWithCamera({lines[1], lines[2]});
  EXPECT_NEAR(scene.sense.Find<Camera>()->pixel, 0.4 / 800, 1e-9);
  const Eigen::Vector3d centre_C((319.5 - 322) / 800, (239.5 - 236) / 800, 1);
  Eigen::Vector3d centre_S = X_SC * (0.4 * centre_C);
  EXPECT_LT((scene.sense.Find<Camera>()->X_SC.translation() - centre_S).norm(), 1e-8);
  const Eigen::Vector3d right_S = X_SC.linear() * Eigen::Vector3d::UnitX();
  EXPECT_LT((scene.sense.Find<Camera>()->X_SC.linear().col(0) - right_S).norm(), 1e-6);

  options_.plane = false;
  EXPECT_EQ(Run(), 2);
  EXPECT_THAT(output_, HasSubstr("--plane: expected with the rig of one camera"));
  options_.plane = true;

  options_.tip_places = Write("outside.csv", "x,y,z,u,v\n0,0,0,10,10\n0.1,0,0,640,10\n");
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("outside.csv:3: u = 640: expected 0 to 639: it is outside of "
                                 "the image of 640 x 480"));

  options_.tip_places = Write("line.csv",
                              "x,y,z,u,v\n0,0,0,10,10\n0.1,0,0,11,10\n0,0.1,0,10,11\n"
                              "0.1,0.1,0,14,17\n0.2,0.1,0,9,9\n");
  fs::remove(options_.out);
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(output_, HasSubstr("rejected: "));
  EXPECT_FALSE(fs::exists(options_.out));
}

}  // namespace
}  // namespace palpate
