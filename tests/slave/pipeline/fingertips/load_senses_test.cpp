#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "slave/pipeline/fingertips/tactile_estimator.h"
#include "slave/tactile/network/network_file.h"
#include "tests/slave/pipeline/fingertips/tactile_scene.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing_fakes::CubeScene;
using testing_fakes::kAbove;

const std::string kShipped = SourcePath("/deploy/fingertips/simulated-tnn21");

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
  tactile.network = kShipped;
  const auto write = [&](const char* columns) {
    std::string text = columns;
    for (int e = 1; e <= kElectrodeCount; ++e) text += ",E" + std::to_string(e);
    tactile.file = scratch.Write("touch.csv", text + "\n");
  };
  write("t,pac0,pdc");
  EXPECT_EQ(ComplaintOf(scene), "");
  write("t,pac0");
  EXPECT_NE(ComplaintOf(scene).find("touch.csv: no column pdc: " + std::string(kShipped)),
            std::string::npos);
  write("t,pdc");
  EXPECT_NE(ComplaintOf(scene).find("no column pac0"), std::string::npos);
}

TEST(LoadSensesTest, FilesThatCannotBeUsedNameTheirKey) {
  const Scratch scratch;
  const auto none = scratch.path() / "nothing";
  Scene scene = CubeScene(kAbove);
  scene.sense.Find<Tactile>()->network = none;
  EXPECT_THROW(LoadSenses(scene), std::invalid_argument);
  EXPECT_NE(ComplaintOf(scene).find("sense.tactile.network: "), std::string::npos);
  scene.sense.Find<Tactile>()->network.clear();
  scene.sense.Find<Tactile>()->electrodes = none;
  EXPECT_THROW(LoadSenses(scene), std::invalid_argument);
  EXPECT_NE(ComplaintOf(scene).find("sense.tactile.electrodes: "), std::string::npos);
  scene.sense.Find<Tactile>()->electrodes.clear();
  scene.sense.Find<Tactile>()->localise = (scratch.path() / "none.json").string();
  EXPECT_THROW(LoadSenses(scene), std::invalid_argument);
}

TEST(LoadSensesTest, ANetworkWithoutAStateCarriesNone) {
  const Scratch scratch;
  Scene scene = CubeScene(kAbove);
  Tactile& tactile = *scene.sense.Find<Tactile>();
  tactile.carries_state = true;
  NetworkInfo info;
  info.architecture = "rnn_19";
  info.inputs = 19;
  info.outputs = 3;
  info.window = 50;
  NetworkWeights weights;
  weights.LeaveUnscaled(info.inputs, info.outputs);
  weights.lstm = {{WeightMatrix::Zero(19 + 2, 4 * 2), Eigen::VectorXf::Zero(4 * 2)}};
  weights.dense = {{WeightMatrix::Zero(2, 3), Eigen::VectorXf::Zero(3)}};
  WriteForceNetwork(scratch.path() / "recurrent", info, weights);
  tactile.network = scratch.path() / "recurrent";
  EXPECT_EQ(ComplaintOf(scene), "");
  info.architecture = "dnn_19";
  info.window = 1;
  weights.lstm.clear();
  weights.dense = {{WeightMatrix::Zero(19, 3), Eigen::VectorXf::Zero(3)}};
  WriteForceNetwork(scratch.path() / "dense", info, weights);
  tactile.network = scratch.path() / "dense";
  EXPECT_NE(ComplaintOf(scene).find("sense.tactile.state = carried: accepted is windowed"),
            std::string::npos)
      << ComplaintOf(scene);
}

}  // namespace
}  // namespace palpate
