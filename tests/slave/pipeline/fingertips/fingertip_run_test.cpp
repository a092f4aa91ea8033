#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "slave/pipeline/offline/offline_run.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/tactile/network/reference_network.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

const fs::path kData = SourcePath("/../shared/data");

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

// A folder for scenes and what runs write; removed at the end.
class FingertipRunTest : public ::testing::Test {
 protected:
  FingertipRunTest()
      : folder_(fs::temp_directory_path() / ("fingertip-run-" + std::to_string(getpid()))) {
    fs::create_directories(folder_);
  }
  ~FingertipRunTest() override { fs::remove_all(folder_); }

  Scene Load(const std::string& tactile) {
    std::ofstream(folder_ / "scene.yaml")
        << "name: run\nobject:\n  geometry: {box: {size: [200 mm, 40 mm, 40 mm], cells: [20, 4, "
           "4]}}\n"
           "  material: {young_modulus: 3.8 kPa, poisson_ratio: 0.15, density: 45 kg/m3}\n"
           "  fixed: {plane: {axis: z, at: 0}}\n"
           "sense: {tactile: {"
        << tactile << "}}\nmodel: {kind: fem}\n";
    return LoadScene(folder_ / "scene.yaml");
  }

  fs::path folder_;
};

// Reference: what the authors' network gives on the authors' recording in an independent float64
// evaluation, row by row, to 1e-6 N; states.csv has the force of the object on the fingertip, so
// the sign turns. Nine significant digits are written.
TEST_F(FingertipRunTest, TheAuthorsNetworkOnTheAuthorsRecordingComesOutOfProcess) {
  const fs::path recording = kData / "seed001_rf_foam_bar";
  if (!fs::exists(recording)) GTEST_SKIP() << "the real recordings are not here";
  const auto network = JsonOf(AuthorsNetwork(kData / "seed001_biotac_lstm" / "biotac_rnn21"));
  std::ofstream(folder_ / "network.json") << network;
  const Scene scene = Load("source: " + (recording / "rh_tactile.csv").string() +
                           ", finger: rf, rest: first 50, network: .");
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out"}, {});
  const Rows expected = ReadCsv(recording / "lstm_expected_rf.csv");
  const Rows states = ReadCsv(folder_ / "out" / "states.csv");
  ASSERT_EQ(states.size(), 1 + summary.frames);
  ASSERT_EQ(states.front().at(9), "fx");
  ASSERT_EQ(expected.front().at(1), "y0");
  // The estimate exists from the fiftieth sample on.
  ASSERT_EQ(expected.size() - 1, summary.frames - 49);
  for (std::size_t i = 1; i < expected.size(); ++i) {
    const auto& state = states.at(i + 49);
    EXPECT_EQ(state.at(2), "rf");
    EXPECT_NEAR(std::stod(state.at(0)), std::stod(expected[i].at(0)), 1e-6);
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(-std::stod(state.at(9 + k)), std::stod(expected[i].at(1 + k)), 1e-6)
          << "row " << i;
    }
    for (std::size_t k = 3; k < 9; ++k) EXPECT_EQ(state.at(k), "");  // nobody says where it is
  }
  EXPECT_EQ(summary.tracking_lost, 49U);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "summary.json"));
}

}  // namespace
}  // namespace palpate
