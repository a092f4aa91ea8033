#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slave/pipeline/offline/offline_run.h"
#include "slave/pipeline/points/points_scores.h"
#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/pipeline/points/watched_membrane.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
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

class PointsRunTest : public FolderTest {
 protected:
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
    scene.sense.Find<StereoCameras>()->source = StereoCameras::Source::kFiles;
    scene.sense.Find<StereoCameras>()->left = (folder_ / "left-*.png").string();
    scene.sense.Find<StereoCameras>()->right = (folder_ / "right-*.png").string();
    scene.sense.Find<StereoCameras>()->rig = folder_ / "rig.yaml";
    return scene;
  }
  // What a run of recorded pairs is refused with.
  [[nodiscard]] std::string Refusal(const Scene& scene) const {
    return Thrown<std::runtime_error>([&] {
      RunOffline(scene, {folder_ / "out", false, false, {}}, {});
    });
  }
  [[nodiscard]] nlohmann::json Summary() const {
    return nlohmann::json::parse(std::ifstream(folder_ / "out/summary.json"));
  }
};

// Reference: the closed form that bent the drawn dots.
TEST_F(PointsRunTest, RecordedPairsTellForceAndPlace) {
  const testing_fakes::Press press{4.0, {0.005, -0.008}, false};
  const Scene scene = Recorded(press);
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out", true, true, {}}, {});
  EXPECT_EQ(summary.frames, 18U);
  EXPECT_EQ(summary.stages.front().stage, "dots");
  EXPECT_FALSE(summary.has_truth);
  EXPECT_EQ(summary.own["points"]["count"], 31);
  EXPECT_EQ(summary.own["points"]["unseen"], 0);
  const Rows rows = ReadCsv(folder_ / "out/states.csv");
  ASSERT_EQ(rows.size(), 19U);
  ASSERT_EQ(rows[0][13], "validity");
  EXPECT_EQ(rows[1][9], "");  // the rest frame is not known yet: unknown, not zero
  EXPECT_EQ(rows[1][13], "failed");
  EXPECT_EQ(rows[18][3], "");  // nobody says where the tool is
  EXPECT_EQ(rows[18][13], "valid");
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

// Reference: the rig, whose disparity the dots' depth is made from; 31 dots in each of 18 pairs.
TEST_F(PointsRunTest, FollowedPointsAreWrittenWhereAskedFor) {
  const Scene scene = Recorded({});
  RunOffline(scene, {.out = folder_ / "out", .points = true}, {});
  const Rows rows = ReadCsv(folder_ / "out/points.csv");
  ASSERT_EQ(rows.size(), 1U + 18 * 31);
  EXPECT_EQ(rows[0][2], "point");
  const StereoRig rig = RigOf(scene);
  const Eigen::Isometry3d X_LS = scene.sense.Find<StereoCameras>()->X_SL.inverse();
  for (std::size_t i = 1; i < rows.size(); i += 97) {
    ASSERT_EQ(rows[i].size(), rows[0].size());
    const auto number = [&](std::size_t column) { return std::stod(rows[i][column]); };
    const Eigen::Vector3d p_L = X_LS * Eigen::Vector3d(number(3), number(4), number(5));
    const Eigen::Vector2d left = *Project(rig.left, p_L),
                          right = *Project(rig.right, rig.X_RL * p_L);
    EXPECT_NEAR(number(12), left.x(), 0.2);  // what the dot's tilt moves its middle by
    EXPECT_NEAR(number(14), left.x() - right.x(), 0.1);
    EXPECT_GT(number(8), 1e-6);
    EXPECT_LT(number(15), 0.1);
    EXPECT_LT(std::abs(number(16)), 0.2);
  }
}

// With the cameras half as far again from each other all that they see is larger by as much.
TEST_F(PointsRunTest, ARigOfOtherCamerasIsNoSuccessAndTellsNoPlace) {
  const Scene scene = Recorded({4.0, {0, 0}, false});
  StereoRig rig = RigOf(scene);
  rig.X_RL.translation() *= 1.5;
  WriteRig(folder_ / "rig.yaml", rig);
  EXPECT_THAT(Refusal(scene), AllOf(HasSubstr("not complete in any of these 18"),
                                    HasSubstr("no array of dots of this size was found in both"),
                                    HasSubstr("check the sides (left, right), the rig and the")));
  const Rows rows = ReadCsv(folder_ / "out/states.csv");
  ASSERT_EQ(rows.size(), 19U);
  for (std::size_t i = 1; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i][13], "failed");
    for (const std::size_t contact : {6U, 7U, 8U}) EXPECT_EQ(rows[i][contact], "") << i;
  }
  EXPECT_FALSE(fs::exists(folder_ / "out/summary.json"));
}

// A pair turned towards each other sees an array in exchanged pictures, too: bent the other way,
// and with rays that pass each other: before anything presses, too.
TEST_F(PointsRunTest, ExchangedSidesAreDoubted) {
  Scene scene = Recorded({4.0, {0, 0}, false});
  std::swap(scene.sense.Find<StereoCameras>()->left, scene.sense.Find<StereoCameras>()->right);
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out", false, false, {}}, {});
  EXPECT_EQ(summary.validity.at("extrapolated"), 8U);
  EXPECT_EQ(summary.validity.count("valid"), 0U);
  // Rays that pass each other are the cause; a rest shape that is not flat is the consequence.
  EXPECT_EQ(summary.checks.at("epipolar"), 8U);
}

TEST_F(PointsRunTest, FewerPairsThanTheRestFrameTakesAreRefused) {
  const Scene scene = Recorded({});
  for (int i = 8; i <= 18; ++i) {
    for (const char* side : {"left-", "right-"}) {
      fs::remove(folder_ / (side + std::to_string(1000 + i) + ".png"));
    }
  }
  EXPECT_THAT(Refusal(scene), HasSubstr("7 are fewer than the 10 of the rest shape"));
}

// Reference: the run that made the pictures. The rig's file has all digits; what a pixel of its
// rays differs by is rounding.
TEST_F(PointsRunTest, WrittenFramesTellTheSameForcesAgain) {
  Scene scene = testing_fakes::MembraneScene();
  scene.tool->width = 4e-3;
  scene.operator_options.press_depth = 0.3e-3;
  RunOffline(scene, {folder_ / "first", false, true, {}}, {});
  StereoCameras& stereo = *scene.sense.Find<StereoCameras>();
  stereo.source = StereoCameras::Source::kFiles;
  stereo.left = (folder_ / "first/frames/left/*.png").string();
  stereo.right = (folder_ / "first/frames/right/*.png").string();
  stereo.rig = folder_ / "first/frames/rig.yaml";
  RunOffline(scene, {folder_ / "again", false, false, {}}, {});
  const Rows first = ReadCsv(folder_ / "first/states.csv");
  const Rows again = ReadCsv(folder_ / "again/states.csv");
  ASSERT_EQ(first.size(), again.size());
  double largest = 0;
  for (std::size_t i = 1; i < first.size(); ++i) {
    ASSERT_EQ(first[i][13], again[i][13]) << i;
    for (const std::size_t k : {9U, 10U, 11U, 12U}) {
      ASSERT_EQ(first[i][k].empty(), again[i][k].empty()) << i;
      if (first[i][k].empty()) continue;
      const double force = std::stod(first[i][k]);
      EXPECT_NEAR(std::stod(again[i][k]), force, 1e-6 * std::abs(force) + 1e-9) << i;
      largest = std::max(largest, std::abs(force));
    }
  }
  EXPECT_GT(largest, 0.1);
}

TEST_F(PointsRunTest, ATargetGoesOnAsLongAsAskedFor) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/heart-target.yaml"));
  EXPECT_EQ(RunOffline(scene, {folder_ / "out", false, false, {}, 0.5}, {}).frames, 15U);
}

TEST_F(PointsRunTest, FilesAndPressesEndByThemselves) {
  EXPECT_THROW(RunOffline(Recorded({}), {folder_ / "out", false, false, {}, 5}, {}),
               std::invalid_argument);
  EXPECT_THROW(
      RunOffline(testing_fakes::MembraneScene(), {folder_ / "out", false, false, {}, 5}, {}),
      std::invalid_argument);
}

TEST(TrackingCountsTest, PointsNeverSeenAreNotFollowed) {
  TrackingCounts tally;
  std::vector<SurfacePoint> points(3);
  points[0].seen = points[1].seen = true;
  tally.Add(points, false);
  points[1].seen = false;
  tally.Add(points, true);
  tally.Add(points, true);
  EXPECT_EQ(tally.points(), 3U);
  EXPECT_EQ(tally.followed(), 2U);
  EXPECT_EQ(tally.missed(), 2U);  // the third was never there to be missed
}

TEST_F(PointsRunTest, AStopLeavesReadableFiles) {
  const Scene scene = Recorded({});
  std::stop_source source;
  const OfflineOptions options{folder_ / "out", false, false, [&](std::uint64_t done) {
                                 if (done == 3) source.request_stop();
                               }};
  EXPECT_EQ(RunOffline(scene, options, source.get_token()).frames, 3U);
  EXPECT_EQ(ReadCsv(folder_ / "out/states.csv").size(), 4U);
  EXPECT_EQ(Summary()["frames"], 3);
}

// The shipped target for two seconds of its path, 30 pairs a second. The bound is that of the
// product; what comes out is a twentieth of it.
TEST_F(PointsRunTest, AMovingTargetIsFollowedAndItsForceUnknown) {
  const Scene scene = LoadScene(SourcePath("/deploy/scenes/heart-target.yaml"));
  std::stop_source source;
  const OfflineOptions options{folder_ / "out", false, false, [&](std::uint64_t done) {
                                 if (done == 60) source.request_stop();
                               }};
  const OfflineSummary summary = RunOffline(scene, options, source.get_token());
  EXPECT_EQ(summary.stages.front().stage, "texture");
  EXPECT_FALSE(summary.sense.tells_force);
  EXPECT_EQ(summary.tracking_lost, 0U);
  EXPECT_GT(summary.own["place_error"]["count"], 60 * 20);
  EXPECT_LT(summary.own["place_error"]["rms_m"], 0.5e-3);
  const Rows rows = ReadCsv(folder_ / "out/states.csv");
  ASSERT_EQ(rows.size(), 61U);
  EXPECT_EQ(rows[60][9], "");
  EXPECT_EQ(rows[60][13], "failed");
  EXPECT_NE(rows[60][6], "");
  EXPECT_TRUE(Summary()["force_error"].is_null());
}

}  // namespace
}  // namespace palpate
