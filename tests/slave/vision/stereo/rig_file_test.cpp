#include <filesystem>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/core/persistence.hpp>

#include "slave/vision/stereo/rig.h"
#include "tests/slave/vision/stereo/test_rigs.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using testing::HasSubstr;
namespace fs = std::filesystem;

class RigFileTest : public FolderTest {
 protected:
  fs::path Write(const std::string& text) const { return FolderTest::Write("rig.yaml", text); }
  std::string Refusal(const std::string& text) const {
    return Thrown<std::runtime_error>([&] { ReadRig(Write(text)); });
  }

  const StereoRig rig_ = [] {
    StereoRig rig = VergedTestRig({-0.27, -1.0 / 3, 0.0018, -0.0003, 0.24});
    rig.right = {811.1, 812.2, 300.3, 250.4, {1e-3, 0, 0, 0, 0}, {1280, 960}};
    rig.rms_px = 0.21;
    return rig;
  }();
};

void ExpectSame(const Lens& a, const Lens& b) {
  EXPECT_EQ(a.fx, b.fx);
  EXPECT_EQ(a.fy, b.fy);
  EXPECT_EQ(a.cx, b.cx);
  EXPECT_EQ(a.cy, b.cy);
  EXPECT_EQ(a.distortion, b.distortion);
  EXPECT_EQ(a.size, b.size);
}

TEST_F(RigFileTest, WhatIsWrittenIsReadAgain) {
  const fs::path file = folder_ / "written.yaml";
  WriteRig(file, rig_);
  const StereoRig read = ReadRig(file);
  ExpectSame(read.left, rig_.left);
  ExpectSame(read.right, rig_.right);
  EXPECT_LT((read.X_RL.matrix() - rig_.X_RL.matrix()).norm(), 1e-15);
  EXPECT_EQ(read.rms_px, rig_.rms_px);
}

TEST_F(RigFileTest, OpenCvReadsTheFile) {
  const fs::path file = folder_ / "of-opencv.yaml";
  WriteRig(file, rig_);
  const cv::FileStorage storage(file.string(), cv::FileStorage::READ);
  ASSERT_TRUE(storage.isOpened());
  cv::Mat1d K;
  storage["left"]["camera_matrix"] >> K;
  ASSERT_EQ(K.size(), cv::Size(3, 3));
  EXPECT_EQ(K(0, 0), 800);
}

TEST_F(RigFileTest, FilesOfOpenCvAndOfRosAreRead) {
  const StereoRig opencv = ReadRig(Write(R"(%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 5.3e+02, 0., 3.4e+02, 0.,
       5.4e+02, 2.3e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 4
   cols: 1
   dt: d
   data: [ -2.6e-01, -3.8e-02, 1.7e-03, -2.8e-04 ]
)"));
  EXPECT_EQ(opencv.left.fy, 540);
  EXPECT_EQ(opencv.left.distortion, (std::array<double, 5>{-0.26, -0.038, 0.0017, -0.00028, 0}));
  const StereoRig ros = ReadRig(Write(R"(
image_width: 720
image_height: 576
camera_name: left
distortion_model: plumb_bob
camera_matrix: {rows: 3, cols: 3, data: [553.6, 0, 345.1, 0, 590.9, 291.0, 0, 0, 1]}
distortion_coefficients: {rows: 1, cols: 5, data: [-0.01, 0.003, 0.001, 0.002, 0]}
)"));
  EXPECT_EQ(ros.left.size[1], 576);
}

// OpenCV's calibration sample writes XML and JSON; `ros2 topic echo` prints CameraInfo.
TEST_F(RigFileTest, XmlAndJsonOfOpenCvAndTheMessageOfRosAreRead) {
  const StereoRig xml = ReadRig(Write(R"(<?xml version="1.0"?>
<opencv_storage>
<image_width>640</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows><cols>3</cols><dt>d</dt>
  <data>530. 0. 340. 0. 540. 230. 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>5</rows><cols>1</cols><dt>d</dt>
  <data>-0.26 -0.038 0.0017 -0.00028 0.</data></distortion_coefficients>
</opencv_storage>
)"));
  EXPECT_EQ(xml.left.size, (std::array<int, 2>{640, 480}));
  EXPECT_EQ(xml.left.fy, 540);
  EXPECT_EQ(xml.left.distortion, (std::array<double, 5>{-0.26, -0.038, 0.0017, -0.00028, 0}));
  const StereoRig json = ReadRig(Write(R"({
    "image_width": 640, "image_height": 480,
    "camera_matrix": {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d",
                      "data": [530.0, 0.0, 340.0, 0.0, 540.0, 230.0, 0.0, 0.0, 1.0]},
    "distortion_coefficients": {"type_id": "opencv-matrix", "rows": 5, "cols": 1, "dt": "d",
                                "data": [-0.26, -0.038, 0.0017, -0.00028, 0.0]}
})"));
  ExpectSame(json.left, xml.left);
  for (const bool is_ros1 : {false, true}) {
    const char* K = is_ros1 ? "K" : "k";
    const char* D = is_ros1 ? "D" : "d";
    const StereoRig ros = ReadRig(
        Write(std::string("header: {frame_id: left}\nheight: 480\nwidth: 640\ndistortion_model: "
                          "plumb_bob\n") +
              D + ": [-0.26, -0.038, 0.0017, -0.00028, 0.0]\n" + K +
              ": [530.0, 0.0, 340.0, 0.0, 540.0, 230.0, 0.0, 0.0, 1.0]\nbinning_x: 0\n---\n"));
    ExpectSame(ros.left, xml.left);
  }
  EXPECT_THAT(Refusal("<?xml version=\"1.0\"?>\n<camera><fx>530</fx></camera>\n"),
              HasSubstr("rig.yaml: "));
  EXPECT_THAT(Refusal("<html></html>"), HasSubstr("is a web page: expected a camera rig"));
}

constexpr const char* kMatrix = "800, 0, 320, 0, 800, 240";

// The file of one camera; `matrix`: the first two rows.
std::string LensFile(const std::string& matrix, const std::string& distortion) {
  return "image_width: 640\nimage_height: 480\ncamera_matrix: {data: [" + matrix +
         ", 0, 0, 1]}\ndistortion_coefficients: {data: [" + distortion + "]}\n";
}

// The file of two; `rotation`: its diagonal.
std::string PairFile(const std::string& rotation, const std::string& translation) {
  const std::string lens = "{image_width: 640, image_height: 480, camera_matrix: {data: [" +
                           std::string(kMatrix) +
                           ", 0, 0, 1]}, distortion_coefficients: {data: [0, 0, 0, 0, 0]}}\n";
  return "left: " + lens + "right: " + lens + rotation + "T: {data: [" + translation + "]}";
}

const std::string kIdentity = "R: {data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n";
const std::string kMirror = "R: {data: [1, 0, 0, 0, 1, 0, 0, 0, -1]}\n";

// Impossible lens parameters would lead to NaN.
TEST_F(RigFileTest, SaysWhatIsWrongWithAFile) {
  const std::string lens = LensFile(kMatrix, "0, 0, 0, 0");
  EXPECT_EQ(Refusal(lens), "");
  EXPECT_EQ(Refusal(PairFile(kIdentity, "0.06, 0, 0")), "");
  const std::pair<std::string, const char*> files[] = {
      {"a: [1", "rig.yaml: "},
      {"just words", "not a map"},
      {"MATLAB 5.0 MAT-file, Platform: GLNXA64", "a MATLAB file"},
      {"cam0: {camera_model: pinhole, resolution: [640, 480]}",
       "has no `image_width`, only cam0: expected a camera rig with image_width, "
       "image_height"},
      {"", "not a map"},
      {"left: {image_width: 640}", "has no `left.image_height`"},
      {"image_width: -3", "expected 1 to 16384"},
      {"image_width: 16384\nimage_height: 16385", "image_height = 16385: expected 1 to 16384"},
      {LensFile("0, 0, 320, 0, 800, 240", "0, 0, 0, 0"), "focal > 0"},
      {LensFile("5e-324, 0, 320, 0, 800, 240", "0, 0, 0, 0"),
       "camera_matrix: fx = 4.94066e-324: expected a focal > 0 [px], 0.001 to 1e+09"},
      {LensFile("800, 0, 320, 0, 1e300, 240", "0, 0, 0, 0"), "camera_matrix: fy = 1e+300"},
      {LensFile("800, 0, -1e9, 0, 800, 240", "0, 0, 0, 0"), "camera_matrix: cx = -1e+09"},
      {LensFile(".nan, 0, 320, 0, 800, 240", "0, 0, 0, 0"), "finite"},
      {LensFile(kMatrix, "0, 0, 0, 0, 0, 1, 0, 0"), "plumb bob"},
      {LensFile(kMatrix, "1e200, 0, 0, 0"),
       "distortion_coefficients = 1e+200: expected a number, -1e+06 to 1e+06"},
      {lens + "distortion_model: equidistant",
       "distortion_model = equidistant: expected plumb_bob"},
      {lens + "distortion_model: [plumb_bob]", "expected plumb_bob"},
      {PairFile("", "0.06, 0, 0"), "has no `R`"},
      {PairFile(kMirror, "1, 0, 0"), "rotation"},
      {PairFile(kIdentity, "0, 0, 0"), "two cameras apart"},
      {PairFile(kIdentity, "1e-300, 0, 0"),
       "length of T = 1e-300: expected two cameras apart [m], 1e-12 to 1000"}};
  for (const auto& [text, words] : files) EXPECT_THAT(Refusal(text), HasSubstr(words)) << text;
}

TEST_F(RigFileTest, WhatCannotBeOpenedIsRefused) {
  EXPECT_THROW(ReadRig(folder_), std::runtime_error);
  EXPECT_THROW(ReadRig(folder_ / "missing.yaml"), std::runtime_error);
  EXPECT_THAT([] { ReadRig("/dev/zero"); },
              testing::ThrowsMessage<std::runtime_error>(HasSubstr("/dev/zero: cannot be read")));
  EXPECT_THROW(WriteRig(folder_ / "no" / "such" / "rig.yaml", rig_), std::runtime_error);
}

}  // namespace
}  // namespace palpate
