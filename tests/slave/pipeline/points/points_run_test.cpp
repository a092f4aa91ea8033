#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "slave/live/offline_run.h"
#include "slave/pipeline/points/points_scores.h"
#include "slave/pipeline/points/surface_point_tracker.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/pipeline/points/watched_membrane.h"
#include "tests/support/csv_columns.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

class PointsRunTest : public FolderTest {
 protected:
  // Twelve pairs at rest, then six under `press`, as files; the scene that reads them.
  Scene Recorded(const testing_fakes::Press& press) {
    Scene scene = testing_fakes::WatchedMembraneScene();
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
  // Returns the error message of a run with recorded pairs.
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
TEST_F(PointsRunTest, RecordedPairsGiveForceAndPosition) {
  const testing_fakes::Press press{4.0, {0.005, -0.008}, false};
  const Scene scene = Recorded(press);
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out", true, true, {}}, {});
  EXPECT_EQ(summary.frames, 18U);
  EXPECT_EQ(summary.stages.front().stage, "dots");
  EXPECT_FALSE(summary.has_truth);
  EXPECT_EQ(summary.own["points"]["count"], 31);
  EXPECT_EQ(summary.own["points"]["unseen"], 0);
  const CsvColumns states = ReadColumns(folder_ / "out/states.csv");
  ASSERT_EQ(states.at("fx").size(), 18U);
  EXPECT_EQ(states.at("fx").front(), "");  // the rest frame is not known yet: unknown, not zero
  EXPECT_EQ(states.at("validity").front(), "failed");
  EXPECT_EQ(states.at("tip_x").back(), "");  // the tool's position is not given
  EXPECT_EQ(states.at("validity").back(), "valid");
  EXPECT_NEAR(std::stod(states.at("fz").back()), press.force, 0.05 * press.force);
  EXPECT_NEAR(std::stod(states.at("contact_x").back()), press.p_O.x(), 1e-3);
  EXPECT_NEAR(std::stod(states.at("contact_y").back()), press.p_O.y(), 1e-3);
  const nlohmann::json json = Summary();
  EXPECT_EQ(json["frames"], 18);
  EXPECT_TRUE(json["force_error"].is_null());
  EXPECT_TRUE(json["displacement_error"].is_null());
  EXPECT_TRUE(json["steps"].empty());
  for (const char* stage : {"capture", "dots", "mechanics", "total"}) {
    EXPECT_TRUE(json["stages"].contains(stage)) << stage;
  }
  const cv::Mat written = cv::imread((folder_ / "out/images/000018.jpg").string());
  EXPECT_EQ(written.cols, 640);
  EXPECT_FALSE(cv::imread((folder_ / "out/frames/left/000018.png").string()).empty());
  EXPECT_FALSE(cv::imread((folder_ / "out/frames/right/000018.png").string()).empty());
}

// With 1.5 times the distance between the cameras, everything they measure is larger by this
// factor.
TEST_F(PointsRunTest, AWrongRigFailsAndReportsNoPosition) {
  const Scene scene = Recorded({4.0, {0, 0}, false});
  StereoRig rig = RigOf(scene);
  rig.X_RL.translation() *= 1.5;
  WriteRig(folder_ / "rig.yaml", rig);
  EXPECT_THAT(Refusal(scene), AllOf(HasSubstr("not complete in any of these 18"),
                                    HasSubstr("no array of dots of this size was found in both"),
                                    HasSubstr("check the sides (left, right), the rig and the")));
  const CsvColumns states = ReadColumns(folder_ / "out/states.csv");
  EXPECT_EQ(states.at("validity"), std::vector<std::string>(18, "failed"));
  EXPECT_EQ(states.at("contact_x"), std::vector<std::string>(18));
  EXPECT_FALSE(fs::exists(folder_ / "out/summary.json"));
}

// With exchanged images of two verged cameras the array is still found, but it is curved the other
// way and the rays miss each other, even before a press.
TEST_F(PointsRunTest, ExchangedSidesAreFlagged) {
  Scene scene = Recorded({4.0, {0, 0}, false});
  std::swap(scene.sense.Find<StereoCameras>()->left, scene.sense.Find<StereoCameras>()->right);
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out", false, false, {}}, {});
  EXPECT_EQ(summary.validity.at("extrapolated"), 8U);
  EXPECT_EQ(summary.validity.count("valid"), 0U);
  // The cause is that the rays miss each other; the consequence is a rest shape that is not flat.
  EXPECT_EQ(summary.checks.at("epipolar"), 8U);
}

// Reference: the run that made the images. The rig's file has all digits, so its rays differ only
// by rounding.
TEST_F(PointsRunTest, WrittenFramesGiveTheSameForces) {
  Scene scene = LoadScene(SourcePath("/deploy/scenes/rubber-membrane.yaml"),
                          {"operator.press.depth=2 mm", "operator.press.speed=10 mm/s"});
  RunOffline(scene, {folder_ / "first", false, true, {}}, {});
  StereoCameras& stereo = *scene.sense.Find<StereoCameras>();
  stereo.source = StereoCameras::Source::kFiles;
  stereo.left = (folder_ / "first/frames/left/*.png").string();
  stereo.right = (folder_ / "first/frames/right/*.png").string();
  stereo.rig = folder_ / "first/frames/rig.yaml";
  RunOffline(scene, {folder_ / "again", false, false, {}}, {});
  const CsvColumns first = ReadColumns(folder_ / "first/states.csv");
  const CsvColumns again = ReadColumns(folder_ / "again/states.csv");
  ASSERT_EQ(first.at("validity"), again.at("validity"));
  double largest = 0;
  for (const char* column : {"fx", "fy", "fz", "sigma"}) {
    for (std::size_t i = 0; i < first.at(column).size(); ++i) {
      const std::string &cell = first.at(column)[i], &other = again.at(column)[i];
      ASSERT_EQ(cell.empty(), other.empty()) << column << i;
      if (cell.empty()) continue;
      const double force = std::stod(cell);
      EXPECT_NEAR(std::stod(other), force, 1e-6 * std::abs(force) + 1e-9) << column << i;
      largest = std::max(largest, std::abs(force));
    }
  }
  EXPECT_GT(largest, 0.1);
}

}  // namespace
}  // namespace palpate
