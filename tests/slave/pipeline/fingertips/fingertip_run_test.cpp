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

// Without a network no force is told, so none is compared: an error that is not known, not zero.
TEST_F(FingertipRunTest, WhereNoForceIsToldItsErrorIsNull) {
  const Scene scene = Load("source: simulated, rate: 100 Hz");
  std::stop_source stop;
  const auto progress = [&](std::uint64_t done) {
    if (done == 5) stop.request_stop();
  };
  const OfflineSummary summary =
      RunOffline(scene, {folder_ / "out", false, false, progress}, stop.get_token());
  EXPECT_TRUE(summary.has_truth);
  const auto json = nlohmann::json::parse(std::ifstream(folder_ / "out" / "summary.json"));
  EXPECT_TRUE(json["force_error"].is_null());
}

// A recording of two fingertips, one of which presses: nothing is known of forces without a
// network, and the rows say so.
TEST_F(FingertipRunTest, EveryFingertipHasARowPerSample) {
  std::ofstream csv(folder_ / "two.csv");
  csv << "t";
  for (const char* finger : {"ff", "th"}) {
    for (int e = 1; e <= 19; ++e) csv << ',' << finger << "_E" << e;
    csv << ',' << finger << "_pac0," << finger << "_pdc";
  }
  csv << '\n';
  for (int i = 0; i < 100; ++i) {
    csv << 0.01 * i;
    for (int f = 0; f < 2; ++f) {
      for (int e = 0; e < 21; ++e) csv << ',' << (f == 0 && i > 60 && e < 10 ? 2960 : 3000);
    }
    csv << '\n';
  }
  csv.close();
  const Scene scene = Load(
      "source: two.csv, rest: first 20, fingers: {ff: {pose: "
      "{translation: [100 mm, 20 mm, 46 "
      "mm]}}, "
      "th: {pose: {translation: [50 mm, 20 mm, 60 mm]}, motion: stands}}");
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out"}, {});
  EXPECT_EQ(summary.frames, 100U);
  const Rows states = ReadCsv(folder_ / "out" / "states.csv");
  ASSERT_EQ(states.size(), 201U);
  EXPECT_EQ(states[1].at(2), "ff");
  EXPECT_EQ(states[2].at(2), "th");
  const auto& pressing = states[199];
  EXPECT_NE(pressing.at(6), "");  // it touches somewhere
  EXPECT_EQ(pressing.at(9), "");  // with a force that nobody knows
  EXPECT_EQ(pressing.at(13), "failed");
  EXPECT_EQ(states[200].at(6), "");
}

TEST_F(FingertipRunTest, ARecordingShorterThanItsRestIsRefused) {
  std::ofstream csv(folder_ / "short.csv");
  csv << "t";
  for (int e = 1; e <= 19; ++e) csv << ",E" << e;
  csv << ",pac0,pdc\n";
  for (int i = 0; i < 12; ++i) {
    csv << 0.01 * i;
    for (int e = 0; e < 21; ++e) csv << ',' << 3000 + (i + e) % 2;
    csv << '\n';
  }
  csv.close();
  const auto run = [&](const std::string& rest) {
    return RunOffline(Load("source: short.csv, rest: " + rest), {folder_ / "out"}, {});
  };
  EXPECT_EQ(run("first 12").frames, 12U);
  EXPECT_THROW(run("first 13"), std::runtime_error);
}

TEST_F(FingertipRunTest, AStreamHasNoEndAndIsRefused) {
  EXPECT_THROW(RunOffline(Load("source: stream"), {folder_ / "out"}, {}), std::invalid_argument);
}

}  // namespace
}  // namespace palpate
