#include "slave/pipeline/stereo_run.h"

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <unistd.h>

#include "shared/scene/scene_loader.h"
#include "slave/pipeline/eyes.h"
#include "tests/slave/pipeline/watched_membrane.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using Rows = std::vector<std::vector<std::string>>;

Rows ReadCsv(const fs::path& file) {
  Rows rows;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream fields(line);
    rows.emplace_back();
    for (std::string field; std::getline(fields, field, ',');) rows.back().push_back(field);
  }
  return rows;
}

// A folder for pictures and what runs write; removed at the end.
class StereoRunTest : public ::testing::Test {
 protected:
  StereoRunTest()
      : folder_(fs::temp_directory_path() / ("stereo-run-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~StereoRunTest() override { fs::remove_all(folder_); }

  // Twelve pairs at rest, then six under `press`, as files; the scene that reads them.
  Scene Recorded(const testing_fakes::Press& press) {
    Scene scene = testing_fakes::MembraneScene();
    WriteRig(folder_ / "rig.yaml", RigOf(scene));
    for (int i = 1; i <= 18; ++i) {
      const auto pair = testing_fakes::DotPairs().Draw(i <= 12 ? testing_fakes::Press{} : press,
                                                       static_cast<std::uint64_t>(i));
      const std::string number = std::to_string(1000 + i) + ".png";
      cv::imwrite((folder_ / ("left-" + number)).string(), pair.left);
      cv::imwrite((folder_ / ("right-" + number)).string(), pair.right);
    }
    scene.sense.stereo->source = StereoCameras::Source::kFiles;
    scene.sense.stereo->left = (folder_ / "left-*.png").string();
    scene.sense.stereo->right = (folder_ / "right-*.png").string();
    scene.sense.stereo->rig = folder_ / "rig.yaml";
    return scene;
  }
  [[nodiscard]] nlohmann::json Summary() const {
    return nlohmann::json::parse(std::ifstream(folder_ / "out/summary.json"));
  }

  fs::path folder_;
};

// Reference: the closed form that bent the drawn dots.
TEST_F(StereoRunTest, RecordedPairsTellForceAndPlace) {
  const testing_fakes::Press press{4.0, {0.005, -0.008}, false};
  const Scene scene = Recorded(press);
  const StereoSummary summary = RunStereo(scene, {folder_ / "out", true, true, {}}, {});
  EXPECT_EQ(summary.frames, 18U);
  EXPECT_EQ(summary.eyes, "dots");
  EXPECT_FALSE(summary.has_truth);
  EXPECT_EQ(summary.points, 31U);
  EXPECT_EQ(summary.points_unseen, 0U);
  const Rows rows = ReadCsv(folder_ / "out/states.csv");
  ASSERT_EQ(rows.size(), 19U);
  ASSERT_EQ(rows[0].back(), "validity");
  EXPECT_EQ(rows[1][9], "");  // the rest frame is not known yet: unknown, not zero
  EXPECT_EQ(rows[1].back(), "failed");
  EXPECT_EQ(rows[18][3], "");  // nobody says where the tool is
  EXPECT_EQ(rows[18].back(), "valid");
  EXPECT_NEAR(std::stod(rows[18][11]), press.force, 0.05 * press.force);
  EXPECT_NEAR(std::stod(rows[18][6]), press.p_O.x(), 1e-3);
  EXPECT_NEAR(std::stod(rows[18][7]), press.p_O.y(), 1e-3);
  const nlohmann::json json = Summary();
  EXPECT_EQ(json["frames"], 18);
  EXPECT_TRUE(json["force_error"].is_null());
  EXPECT_TRUE(json["displacement_error"].is_null());
  EXPECT_TRUE(json["steps"].empty());
  for (const char* stage : {"capture", "dots", "mechanics", "total"}) {
    EXPECT_TRUE(json["stages"].contains(stage)) << stage;
  }
  const cv::Mat written = cv::imread((folder_ / "out/pictures/000018.jpg").string());
  EXPECT_EQ(written.cols, 640);
  EXPECT_FALSE(cv::imread((folder_ / "out/frames/left/000018.png").string()).empty());
  EXPECT_FALSE(cv::imread((folder_ / "out/frames/right/000018.png").string()).empty());
}

TEST_F(StereoRunTest, PicturesOfAnotherSizeThanTheRigsAreRefusedInWords) {
  const Scene scene = Recorded({});
  for (int i = 1; i <= 18; ++i) {
    const auto file = folder_ / ("right-" + std::to_string(1000 + i) + ".png");
    cv::imwrite(file.string(), cv::Mat::zeros(240, 320, CV_8UC1));
  }
  EXPECT_THROW(RunStereo(scene, {folder_ / "out", false, false, {}}, {}), std::runtime_error);
}

TEST_F(StereoRunTest, AStopLeavesReadableFiles) {
  const Scene scene = Recorded({});
  std::stop_source source;
  const StereoRunOptions options{folder_ / "out", false, false, [&](std::uint64_t done) {
                                   if (done == 3) source.request_stop();
                                 }};
  EXPECT_EQ(RunStereo(scene, options, source.get_token()).frames, 3U);
  EXPECT_EQ(ReadCsv(folder_ / "out/states.csv").size(), 4U);
  EXPECT_EQ(Summary()["frames"], 3);
}

// The shipped target for two seconds of its path, 30 pairs a second. The bound is that of the
// product; what comes out is a twentieth of it.
TEST_F(StereoRunTest, AMovingTargetIsFollowedAndItsForceUnknown) {
  const Scene scene = LoadScene(PALPATE_SOURCE_DIR "/deploy/scenes/heart-target.yaml");
  std::stop_source source;
  const StereoRunOptions options{folder_ / "out", false, false, [&](std::uint64_t done) {
                                   if (done == 60) source.request_stop();
                                 }};
  const StereoSummary summary = RunStereo(scene, options, source.get_token());
  EXPECT_EQ(summary.eyes, "texture");
  EXPECT_FALSE(summary.tells_force);
  EXPECT_EQ(summary.tracking_lost, 0U);
  EXPECT_GT(summary.place.count(), 60U * 20U);
  EXPECT_LT(summary.place.rms(), 0.5e-3);
  const Rows rows = ReadCsv(folder_ / "out/states.csv");
  ASSERT_EQ(rows.size(), 61U);
  EXPECT_EQ(rows[60][9], "");
  EXPECT_EQ(rows[60].back(), "failed");
  EXPECT_NE(rows[60][6], "");
  EXPECT_TRUE(Summary()["force_error"].is_null());
}

}  // namespace
}  // namespace palpate
