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
#include "slave/tactile/localise/fitted_localiser.h"
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
  EXPECT_THAT(complaint([](O* o) {
                o->networks = {"rnn_21", "localiser"};
              }),
              HasSubstr("without other networks"));
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

// Signals of the formula's own making: the electrodes under the contact fall with the cosine of
// the angle to its normal, which the recording gives in axes turned half about y.
std::string NormalsRecording() {
  const ElectrodeLayout layout = SimulatedLayout(7e-3);
  std::ostringstream text;
  text << "rel_time_s,pdc";
  for (int e = 1; e <= kElectrodeCount; ++e) text << ",E" << e;
  text << ",nx,ny,nz\n";
  for (int i = 0; i < 600; ++i) {
    const bool touching = i % 60 >= 20;
    const double along = 0.6 * std::sin(0.037 * i), across = 0.7 * std::cos(0.023 * i);
    const Eigen::Vector3d n = Eigen::Vector3d(0.4 + along, across, -1).normalized();
    text << 0.01 * i << "," << (touching ? 2600 : 2400);
    for (const Eigen::Vector3d& e : layout.n_F) {
      const double cosine = std::max(e.dot(n), 0.0);
      text << "," << 3000 - (touching ? std::round(300 * std::pow(cosine, 6)) : 0.0);
    }
    text << "," << -n.x() << "," << n.y() << "," << -n.z() << "\n";
  }
  return text.str();
}

TEST_F(TrainCommandTest, LocalisersAreFittedInTheFingertipsFrame) {
  options_.data = {Write("normals.csv", NormalsRecording())};
  options_.networks = {"localiser"};
  options_.electrodes = "simulated";
  const std::string printed = Run();
  EXPECT_THAT(printed, HasSubstr("400 samples in contact"));
  EXPECT_THAT(printed, HasSubstr("-x,y,-z"));
  const LocaliserWeights weights = ReadLocaliser(options_.out / "localiser.json");
  EXPECT_LT(weights.median_error, 0.15);
}

TEST_F(TrainCommandTest, LocaliserDataThatCannotBeUsedIsSaid) {
  options_.networks = {"localiser"};
  options_.electrodes = "simulated";
  const std::string good = NormalsRecording();
  options_.data = {Write("a.csv", good)};
  options_.normals = "x,y,y";
  EXPECT_THAT(Complaint(), HasSubstr("x,y,y"));
  options_.normals = "auto";
  options_.contact_pdc = 5000;
  EXPECT_THAT(Complaint(), HasSubstr("in contact"));
  options_.contact_pdc = 100;
  EXPECT_THAT(Complaint(), HasSubstr("without contact"));
  options_.contact_pdc.reset();
  std::string other = good;
  other.replace(other.find(",nx"), 3, ",mx");
  options_.data = {Write("b.csv", other)};
  EXPECT_THAT(Complaint(), HasSubstr("nx, ny, nz"));
}

TEST_F(TrainCommandTest, ALocaliserIsNotFittedToElectrodesThatNobodyNamed) {
  options_.data = {Write("normals.csv", NormalsRecording())};
  options_.networks = {"localiser"};
  EXPECT_THAT(Complaint(), HasSubstr("--electrodes simulated"));
  EXPECT_FALSE(std::filesystem::exists(options_.out / "localiser.json"));
}

// Normals mirrored, which no rotation makes good.
TEST_F(TrainCommandTest, ALocaliserThatLearnsNonsenseIsNotWritten) {
  options_.networks = {"localiser"};
  options_.data = {Write("normals.csv", NormalsRecording())};
  options_.electrodes = "simulated";
  options_.normals = "x,y,-z";
  EXPECT_THAT(Complaint(), HasSubstr("nothing written"));
  EXPECT_FALSE(std::filesystem::exists(options_.out / "localiser.json"));
}

TEST_F(TrainCommandTest, OfSeveralLocaliserRecordingsTheUsableOnesAreTaken) {
  options_.networks = {"localiser"};
  options_.electrodes = "simulated";
  const std::string good = Write("normals.csv", NormalsRecording());
  const std::string bad = Write("bad.csv", "t,E1\n0,1\n");
  options_.data = {bad, good};
  testing::internal::CaptureStderr();
  EXPECT_THAT(Run(), HasSubstr("400 samples in contact"));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), HasSubstr("warning: not used: " + bad));
  options_.data = {bad, Write("worse.csv", "")};
  EXPECT_THAT(Complaint(), testing::AllOf(HasSubstr("bad.csv"), HasSubstr("worse.csv")));
}

TEST_F(TrainCommandTest, ALocaliserTestWithoutAContactIsNoTest) {
  options_.networks = {"localiser"};
  options_.electrodes = "simulated";
  options_.data = {Write("normals.csv", NormalsRecording())};
  options_.test = {Write("other.csv", NormalsRecording()) + "@0:0.1"};
  EXPECT_THAT(Complaint(), HasSubstr("other.csv@0:0.1: no sample in contact"));
  // Contacts by pdc, of which no electrode tells anything.
  std::string silent = "rel_time_s,pdc";
  for (int e = 1; e <= kElectrodeCount; ++e) silent += ",E" + std::to_string(e);
  silent += ",nx,ny,nz\n";
  for (int i = 0; i < 200; ++i) {
    silent += std::to_string(0.01 * i) + (i % 20 < 10 ? ",2400" : ",2440");
    for (int e = 1; e <= kElectrodeCount; ++e) silent += i % 20 < 10 ? ",3000" : ",3100";
    silent += ",0,0,1\n";
  }
  options_.test = {Write("silent.csv", silent)};
  EXPECT_THAT(Complaint(), HasSubstr("test recordings: no contact found in any of 100 samples"));
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

// README of the recording: after one rotation the paper's formula gives 7.9 degrees.
TEST_F(RealFoamTest, ALocaliserFittedOnOneHalfIsGoodOnTheOther) {
  options_.finger.clear();
  options_.data = {std::string(kData) + "biotac_contact_direction/trial1.csv"};
  options_.electrodes = std::string(kData) + "seed001_biotac_lstm/biotac_electrodes_pose.csv";
  options_.networks = {"localiser"};
  options_.contact_pdc = 2440;
  const std::string printed = Run();
  const std::size_t second = printed.find("second half fitted");
  const auto aligned = [](const std::string& line) {
    return std::stod(line.substr(line.find("deg, ") + 5));
  };
  EXPECT_LE(aligned(printed.substr(printed.find("first half fitted"))), 5.5);
  EXPECT_LE(aligned(printed.substr(second)), 5.5);
}

}  // namespace
}  // namespace palpate
