#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "slave/live/offline_run.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/tactile/network/reference_network.h"
#include "tests/support/csv_columns.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

const fs::path kFingertipData = SourcePath("/../shared/data");

class FingertipRunTest : public FolderTest {
 protected:
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
};

// Reference: an independent float64 evaluation of the authors' network on the authors' recording,
// row by row, to 1e-6 N. states.csv contains the force of the object on the fingertip, so the sign
// is opposite. Nine significant digits are written.
TEST_F(FingertipRunTest, TheAuthorsNetworkOnTheAuthorsRecordingComesOutOfProcess) {
  const fs::path recording = kFingertipData / "seed001_rf_foam_bar";
  if (!fs::exists(recording)) GTEST_SKIP() << "the real recordings are not here";
  const auto network =
      JsonOf(AuthorsNetwork(kFingertipData / "seed001_biotac_lstm" / "biotac_rnn21"));
  std::ofstream(folder_ / "network.json") << network;
  const Scene scene = Load("source: " + (recording / "rh_tactile.csv").string() +
                           ", finger: rf, rest: first 50, network: .");
  const OfflineSummary summary = RunOffline(scene, {folder_ / "out"}, {});
  const CsvColumns expected = ReadColumns(recording / "lstm_expected_rf.csv");
  const CsvColumns states = ReadColumns(folder_ / "out" / "states.csv");
  ASSERT_EQ(states.at("t").size(), summary.frames);
  const auto t = NumbersOf(expected, "rel_time_s");
  // The estimate exists from the fiftieth sample on.
  ASSERT_EQ(t.size(), summary.frames - 49);
  for (const auto& [force, output] : {std::pair{"fx", "y0"}, {"fy", "y1"}, {"fz", "y2"}}) {
    const auto outputs = NumbersOf(expected, output);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      ASSERT_NEAR(-std::stod(states.at(force)[i + 49]), outputs[i], 1e-6) << force << ", row " << i;
    }
  }
  for (std::size_t i = 0; i < t.size(); ++i) {
    EXPECT_EQ(states.at("finger")[i + 49], "rf");
    EXPECT_NEAR(std::stod(states.at("t")[i + 49]), t[i], 1e-6);
    for (const char* unknown : {"tip_x", "contact_x"}) {  // its position is not given
      EXPECT_EQ(states.at(unknown)[i + 49], "");
    }
  }
  EXPECT_EQ(summary.tracking_lost, 49U);
  EXPECT_TRUE(fs::exists(folder_ / "out" / "summary.json"));
}

}  // namespace
}  // namespace palpate
