#include "slave/commands/train/train.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/network/network_file.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using testing::HasSubstr;

const std::string kData = SourcePath("/../shared/data/");

class TrainCommandTest : public testing::Test {
 protected:
  TrainCommandTest()
      : folder_(std::filesystem::path(BinaryPath()) / "test_train" /
                testing::UnitTest::GetInstance()->current_test_info()->name()) {
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    options_.data = {"simulated"};
    options_.out = folder_ / "out";
    options_.presses = 30;
    options_.training.epochs = 2;
  }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
    return (folder_ / name).string();
  }
  // What it prints; the exit code must be 0.
  std::string Run() {
    testing::internal::CaptureStdout();
    const int exit_code = RunTrain(options_, {});
    EXPECT_EQ(exit_code, 0);
    return testing::internal::GetCapturedStdout();
  }
  template <typename Error = std::invalid_argument>
  std::string Complaint() {
    testing::internal::CaptureStdout();
    std::string said = "nothing";
    try {
      RunTrain(options_, {});
    } catch (const Error& e) {
      said = e.what();
    }
    testing::internal::GetCapturedStdout();
    return said;
  }

  std::filesystem::path folder_;
  TrainOptions options_;
};

TEST_F(TrainCommandTest, WritesTheNetworkAndHowItCameAbout) {
  options_.networks = {"rnn_21"};
  options_.training.epochs = 1;
  const std::string printed = Run();
  EXPECT_THAT(printed, HasSubstr("by whole recordings"));
  EXPECT_THAT(printed, HasSubstr("RMSE [mN]"));
  const NetworkFile file = ReadForceNetwork(options_.out);
  EXPECT_EQ(file.info.architecture, "rnn_21");
  EXPECT_EQ(file.info.window, 50);
  EXPECT_GT(file.info.learnt_force, 1);
  EXPECT_GT(file.info.sigma.minCoeff(), 0);
  EXPECT_THAT(file.info.origin, HasSubstr("train simulated --network rnn_21 --presses 30"));
  EXPECT_THAT(file.training, HasSubstr("test_smse"));
  std::ifstream epochs(options_.out / "training.csv");
  std::string line;
  std::getline(epochs, line);
  EXPECT_EQ(line, "epoch,loss,validation_loss");
  std::getline(epochs, line);
  EXPECT_THAT(line, testing::StartsWith("1,"));
}

TEST_F(TrainCommandTest, SeveralNetworksGetFoldersAndOneTable) {
  options_.networks = {"dnn_19", "dnn_21", "dnn_19"};
  const std::string printed = Run();
  EXPECT_THAT(printed, HasSubstr("\ndnn_19  "));
  EXPECT_THAT(printed, HasSubstr("\ndnn_21  "));
  EXPECT_EQ(ReadForceNetwork(options_.out / "dnn_19").info.inputs, 19);
  EXPECT_EQ(ReadForceNetwork(options_.out / "dnn_21").info.inputs, 21);
}

// The paper's figures for rnn_21 are 0.3018, 0.1854, 0.0569. On contacts of other starts a quickly
// trained feed-forward network is already below them.
TEST_F(TrainCommandTest, SimulatedContactsNotTrainedOnAreMetBetterThanInThePaper) {
  options_.networks = {"dnn_21"};
  options_.presses = 600;
  options_.training.epochs = 25;
  Run();
  const NetworkFile file = ReadForceNetwork(options_.out);
  const std::size_t at = file.training.find("test_smse");
  ASSERT_NE(at, std::string::npos);
  std::istringstream numbers(file.training.substr(file.training.find('[', at) + 1));
  double x = 1, y = 1, z = 1;
  char comma = 0;
  numbers >> x >> comma >> y >> comma >> z;
  EXPECT_LT(x, 0.3018);
  EXPECT_LT(y, 0.1854);
  EXPECT_LT(z, 0.0569);
}

TEST_F(TrainCommandTest, TheSameSeedWritesTheSameNetwork) {
  options_.networks = {"dnn_21"};
  const auto text = [&](const std::string& out, int threads) {
    options_.out = folder_ / out;
    options_.training.threads = threads;
    Run();
    std::stringstream all;
    all << std::ifstream(options_.out / "network.json").rdbuf();
    return all.str();
  };
  EXPECT_EQ(text("one", 1), text("two", 2));
}

TEST_F(TrainCommandTest, AStopBeforeAnythingIsLearntIsSaid) {
  std::stop_source stop;
  stop.request_stop();
  testing::internal::CaptureStdout();
  EXPECT_THROW(RunTrain(options_, stop.get_token()), std::runtime_error);
  testing::internal::GetCapturedStdout();
}

TEST_F(TrainCommandTest, WhatCannotBeUsedIsSaid) {
  const TrainOptions good = options_;
  const auto complaint = [&](auto change) {
    options_ = good;
    change(&options_);
    return Complaint();
  };
  using O = TrainOptions;
  EXPECT_THAT(complaint([](O* o) { o->networks = {"rnn_20"}; }), HasSubstr("rnn_20"));
  EXPECT_THAT(complaint([](O* o) { o->optimiser = "momentum"; }), HasSubstr("adam or sgd"));
  EXPECT_THAT(complaint([](O* o) { o->rest = 0; }), HasSubstr("--rest 0"));
  EXPECT_THAT(complaint([](O* o) { o->presses = 0; }), HasSubstr("--presses 0"));
  EXPECT_THAT(complaint([](O* o) { o->training.epochs = 0; }),
              HasSubstr("epochs 0: accepted is 1"));
  EXPECT_THAT(complaint([](O* o) { o->seed = -1; }), HasSubstr("--seed -1: accepted is 0 or more"));
  EXPECT_THAT(complaint([](O* o) { o->data = {"none.csv"}; }), HasSubstr("none.csv"));
  EXPECT_THAT(complaint([](O* o) { o->data = {}; }), HasSubstr("DATA"));
  EXPECT_THAT(complaint([](O* o) { o->from = "nowhere"; }), HasSubstr("nowhere"));
  EXPECT_THAT(complaint([](O* o) { o->presses = 1; }), HasSubstr("too few"));
}

TEST_F(TrainCommandTest, WritesOverNothingItReads) {
  options_.data = {Write("training.csv", "t,fz\n0,1\n")};
  options_.out = folder_;
  EXPECT_THAT(Complaint(), HasSubstr("training.csv: accepted is another file"));
  options_.data = {"simulated"};
  Write("network.json", "{}");
  options_.from = folder_;
  EXPECT_THAT(Complaint(), HasSubstr("network.json: accepted is another file"));
}

TEST_F(TrainCommandTest, AFolderThatCannotBeWrittenIsSaidBeforeTraining) {
  options_.out = Write("file", "in the way") + "/out";
  EXPECT_THAT(Complaint<std::runtime_error>(), HasSubstr("--out"));
}

// A press every 1.2 s: the force is -amplitude |sin| while E1 to E19 fall with it, or `wrong`ly.
std::string PressesRecording(const std::string& columns, double amplitude = 1, bool wrong = false) {
  std::ostringstream text;
  text << "rel_time_s,pac0," << columns;
  for (int e = 1; e <= kElectrodeCount; ++e) text << ",E" << e;
  text << ",fx,fy,fz\n";
  for (int i = 0; i < 1300; ++i) {
    const double phase = i < 100 ? 0 : std::fmod(i - 100, 120) / 120;
    const double press = phase > 0.5 ? std::sin(2 * M_PI * (phase - 0.5)) : 0;
    const double signal = wrong ? std::sin(0.7 * i) : press;
    text << 0.01 * i << ",2000," << 2400 + std::round(100 * signal);
    for (int e = 1; e <= kElectrodeCount; ++e) text << "," << 3000 - std::round(10 * e * signal);
    text << ",0,0," << -amplitude * press << "\n";
  }
  return text.str();
}

TEST_F(TrainCommandTest, SamplesCountOnce) {
  const std::string file = Write("a.csv", PressesRecording("pdc"));
  options_.networks = {"dnn_21"};
  options_.data = {file, file};
  EXPECT_THAT(Complaint(), HasSubstr("share samples"));
  options_.data = {file + "@0:5", folder_ / "." / "a.csv@4:13"};
  EXPECT_THAT(Complaint(), HasSubstr("share samples"));
  options_.data = {"simulated", "simulated"};
  EXPECT_THAT(Complaint(), HasSubstr("share samples"));
  options_.data = {file + "@0:5", file + "@5:13"};
  Run();
}

TEST_F(TrainCommandTest, ANetworkOfAllSignalsIsNotTrainedWithoutOne) {
  options_.data = {Write("a.csv", PressesRecording("other"))};
  options_.networks = {"dnn_19", "dnn_21"};
  EXPECT_THAT(Complaint(), HasSubstr("a.csv: no column pdc: network dnn_21 takes"));
  options_.networks = {"dnn_19"};
  Run();
}

TEST_F(TrainCommandTest, AGainIsFittedToForcesLikeTheNetworksOnly) {
  options_.networks = {"dnn_21"};
  options_.data = {Write("a.csv", PressesRecording("pdc"))};
  options_.training.epochs = 15;
  options_.out = folder_ / "known";
  Run();
  options_.from = options_.out;
  options_.out = folder_ / "out";
  options_.data = {Write("twice.csv", PressesRecording("pdc", 2))};
  Run();
  EXPECT_NEAR(ReadForceNetwork(options_.out).info.gain, 2, 0.2);
  std::filesystem::remove_all(options_.out);
  options_.data = {Write("constant.csv", PressesRecording("pdc", 0))};
  EXPECT_THAT(Complaint(), HasSubstr("fz is the same"));
  options_.data = {Write("unlike.csv", PressesRecording("pdc", 1, true))};
  EXPECT_THAT(Complaint(), testing::AnyOf(HasSubstr("correlation"), HasSubstr("no gain")));
  options_.data = {Write("b.csv", PressesRecording("other"))};
  EXPECT_THAT(Complaint(), HasSubstr("b.csv: no column pdc"));
  EXPECT_FALSE(std::filesystem::exists(options_.out / "network.json"));
}

class RealFoamTest : public TrainCommandTest {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kData)) GTEST_SKIP() << "needs " << kData;
    const std::string folder = std::string(kData) + "seed001_rf_foam_bar/";
    recording_ = folder + "rh_tactile.csv+" + folder + "sensor_readings_wrench.csv";
    options_.finger = "rf";
  }
  // The number behind `name` in the line that begins with `fz`, the last one printed.
  static double Last(const std::string& printed, const std::string& name) {
    return std::stod(printed.substr(printed.rfind(name) + name.size()));
  }
  std::string recording_;
};

// The authors' network under-reads this sensor; one gain is taken from a press (with the rest
// around it) and tested on the other.
TEST_F(RealFoamTest, OneGainFromOnePressFitsTheOther) {
  options_.from = std::string(kData) + "seed001_biotac_lstm/biotac_rnn21";
  options_.data = {recording_ + "@0:9.5"};
  options_.test = {recording_ + "@9.5:15"};
  const std::string there = Run();
  EXPECT_LE(Last(there, "fz: RMSE "), 50);
  EXPECT_GE(Last(there, "correlation "), 0.985);
  const NetworkFile file = ReadForceNetwork(options_.out);
  EXPECT_NEAR(file.info.gain, 1.47, 0.03);
  EXPECT_NEAR(file.info.learnt_force, 0.95, 0.05);  // what lies beyond is extrapolated
  std::swap(options_.data, options_.test);
  const std::string back = Run();
  EXPECT_LE(Last(back, "fz: RMSE "), 40);
  EXPECT_GE(Last(back, "correlation "), 0.99);
}

TEST_F(RealFoamTest, TrainedOnTheFirstPressTheSecondIsTracked) {
  options_.data = {recording_ + "@0:9.5"};
  options_.test = {recording_ + "@9.5:15"};
  options_.training.epochs = 40;
  for (const char* network : {"rnn_21", "dnn_21"}) {
    options_.networks = {network};
    EXPECT_GE(Last(Run(), "correlation "), 0.95) << network;
  }
}

}  // namespace
}  // namespace palpate
