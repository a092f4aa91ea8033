#include <string>

#include <gtest/gtest.h>

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/tactile/network/network_file.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using namespace testing_fakes;

const std::string kShippedSense = SourcePath("/deploy/fingertips/simulated-tnn21");

std::string ComplaintOf(const Scene& scene) {
  try {
    LoadSenses(scene);
    return {};
  } catch (const std::exception& error) {
    return error.what();
  }
}

TEST(LoadSensesTest, ARecordingWithoutASignalThatTheNetworkTakesIsRefused) {
  const Scratch scratch;
  Scene scene = CubeScene(kAbove);
  Tactile& tactile = *scene.sense.Find<Tactile>();
  tactile.source = Tactile::Source::kRecording;
  tactile.network = kShippedSense;
  const auto write = [&](const char* columns) {
    std::string text = columns;
    for (int e = 1; e <= kElectrodeCount; ++e) text += ",E" + std::to_string(e);
    tactile.file = scratch.Write("touch.csv", text + "\n");
  };
  write("t,pac0,pdc");
  EXPECT_EQ(ComplaintOf(scene), "");
  write("t,pac0");
  EXPECT_NE(ComplaintOf(scene).find("touch.csv: no column pdc: " + std::string(kShippedSense)),
            std::string::npos);
  write("t,pdc");
  EXPECT_NE(ComplaintOf(scene).find("no column pac0"), std::string::npos);
}

TEST(LoadSensesTest, ANetworkForOtherChannelsIsRefused) {
  Scene scene = CubeScene(kAbove);
  Tactile& tactile = *scene.sense.Find<Tactile>();
  tactile.network = kShippedSense;
  tactile.channels = {16, "kPa"};
  EXPECT_NE(ComplaintOf(scene).find("sense.tactile.channels = 16: expected 19, for which"),
            std::string::npos);
  tactile.channels = {19, "kPa"};
  EXPECT_NE(ComplaintOf(scene).find("sense.tactile.unit = kPa: expected counts, for which"),
            std::string::npos);
  tactile.network.clear();
  EXPECT_NE(ComplaintOf(scene).find("sense.tactile.electrodes is missing: expected a layout"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate
