// Tests `palpate-slave verify` with files whose true values are set by the test.
#include "slave/commands/verify/verify.h"

#include <cmath>
#include <filesystem>
#include <random>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"
#include "slave/commands/verify/known_loads.h"
#include "slave/live/offline_run.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

TEST(KnownLoadsTest, LoadsAreReadAsPeopleDescribeThem) {
  EXPECT_NEAR(ParseLoad("weight 100 g +y").force.y(), 0.980665, 1e-12);
  EXPECT_NEAR(ParseLoad("weight 0.1kg -z").force.z(), -0.980665, 1e-12);
  EXPECT_NEAR(ParseLoad("spring 200 N/m 5 mm +x").force.x(), 1, 1e-12);
  EXPECT_EQ(ParseLoad("force 0 1.2 0").force, Vector3d(0, 1.2, 0));
  EXPECT_EQ(ParseLoad("none").force, Vector3d(0, 0, 0));
  const KnownLoad press = ParseLoad("press 3 mm at 0.01 20 mm 0");
  EXPECT_NEAR(press.depth, 0.003, 1e-15);
  EXPECT_TRUE(press.p_S_tip.isApprox(Vector3d(0.01, 0.02, 0)));
  EXPECT_FALSE(press.force.array().isFinite().any());
  for (const char* line : {"weight", "weight 100 +y", "weight 100 g", "weight 100 g up", "push",
                           "force 1 2", "force 1 2 nan", "none none", "spring 5 mm 200 N/m +x"}) {
    EXPECT_THAT(Thrown<std::invalid_argument>([&] { ParseLoad(line); }), Not(IsEmpty())) << line;
  }
}

class VerifyFilesTest : public FolderTest {
 protected:
  VerifyFilesTest() {
    options_.scene = SourcePath("/deploy/scenes/silicone-block.yaml");
    options_.out = folder_ / "card";
  }
  int Run() const { return RunVerify(options_, {}); }
  nlohmann::json Report() const {
    return nlohmann::json::parse(Scratch::Read(options_.out / "report.json"));
  }
  std::string Verdict(const char* key) const {
    return Report()["cards"][0]["lines"][key]["verdict"];
  }
  std::string LikelyWrong() const { return Report()["cards"][0]["likely_wrong"].dump(); }
  std::string Refusal() const {
    return Thrown<std::exception>([&] { Run(); });
  }

  VerifyOptions options_;
};

// Recorded images of the simulated block are processed again with another scene: tests everything
// from the images to the card. Loads and positions are those of the simulator.
class SimulatedBlockTest : public VerifyFilesTest {
 protected:
  void Record(int seed) {
    const std::string name = "true-" + std::to_string(seed);
    const Scene scene = LoadScene(options_.scene, {"site.seed=" + std::to_string(seed)});
    RunOffline(scene, {.out = folder_ / name, .frames = true}, {});
    std::string text = Scratch::Read(options_.scene);
    const std::string source = "\n    source: simulated";
    text.replace(text.find(source), source.size(), "\n    file: \"" + name + "/frames/%06d.png\"");
    options_.scene = Write("recorded.yaml", text.substr(0, text.find("# The simulated env")));
    std::string table = "t,fx,fy,fz,x,y,z\n";
    const ForceTables states = ReadStates(folder_ / name / "states.csv");
    for (const ForceRow& state : states.at("")) {
      table += Formatted("%.6f,%.9g,%.9g,0,%.9g,%.9g,0\n", state.t, state.measured.x(),
                         state.measured.y(), state.p_estimated.x(), state.p_estimated.y());
    }
    options_.loads = Write("loads.csv", table);
  }
};

TEST_F(SimulatedBlockTest, PassesAndItsFaultsAreFound) {
  for (const int seed : {1, 2}) {
    options_.scene = SourcePath("/deploy/scenes/silicone-block.yaml");
    Record(seed);
    options_.overrides = {};
    EXPECT_EQ(Run(), 0) << Report().dump(1);

    options_.overrides = {"object.material.young_modulus=152.4 kPa"};
    EXPECT_EQ(Run(), 1);
    EXPECT_EQ(Verdict("magnitude"), "wrong");
    EXPECT_EQ(Verdict("position"), "right") << Report().dump(1);
    EXPECT_THAT(LikelyWrong(), HasSubstr("object.material.young_modulus"));

    // About as much as the slave accepts against the object's size in the first image.
    options_.overrides = {"sense.camera.pixel=0.355 mm"};
    EXPECT_EQ(Run(), 1);
    EXPECT_EQ(Verdict("position"), "wrong");
    EXPECT_THAT(LikelyWrong(), HasSubstr("sense.camera.pixel"));
    EXPECT_THAT(LikelyWrong(), Not(HasSubstr("young_modulus")));

    // If the error is larger, the slave refuses the images.
    options_.overrides = {"sense.camera.pixel=0.3605 mm"};
    EXPECT_EQ(Run(), 1);
    EXPECT_THAT(std::string(Report()["refused"]), HasSubstr("camera.pixel"));
  }
}

TEST_F(VerifyFilesTest, TablesGiveOneCardForEachFinger) {
  std::string states = "t,finger,tip_x,tip_y,tip_z,fx,fy,fz,sigma,validity\n";
  std::string loads = "t,until,finger,fx,fy,fz\n";
  for (int load = 0; load < 8; ++load) {
    const double f = 0.2 + 0.1 * load;
    for (int i = 0; i < 5; ++i) {
      const double t = load + 0.1 * i, e = 0.002 * ((7 * load + 3 * i) % 5 - 2);
      states += Formatted("%g,ff,0,0,0,%g,0,0,0.01,valid\n", t, f + e);
      states += Formatted("%g,th,0,0,0,%g,0,0,0.01,valid\n", t, f - e);
    }
    loads +=
        Formatted("%d,%g,ff,%g,0,0\n%d,%g,th,%g,0,0\n", load, load + 0.9, f, load, load + 0.9, -f);
  }
  options_.states = Write("states.csv", states);
  options_.loads = Write("loads.csv", loads);
  options_.scene = SourcePath("/deploy/scenes/foam-cube.yaml");
  EXPECT_EQ(Run(), 1);
  const auto report = Report();
  ASSERT_EQ(report["cards"].size(), 2U);
  EXPECT_EQ(report["cards"][0]["finger"], "ff");
  EXPECT_TRUE(report["cards"][0]["passes"]) << report.dump(1);
  EXPECT_EQ(report["cards"][1]["lines"]["sign"]["verdict"], "wrong") << report.dump(1);
}

TEST_F(VerifyFilesTest, UnusableInputIsNamed) {
  options_.states = Write("states.csv", "t,fx,fy,fz,sigma,validity\n0,0,1,0,0.1,valid\n");
  EXPECT_THAT(Refusal(), HasSubstr("--states: only with --loads or --sensor"));
  options_.sensor = true;
  EXPECT_THAT(Refusal(), HasSubstr("measured_force"));
  options_.sensor = false;
  for (const auto& [loads, message] :
       {std::pair{"t,until,fy\n5,6,2\n", "none matches"},
        {"t,until,fy\n5,4,2\n", "loads.csv:2: until: expected a time after t"},
        {"until,fy\n5,4\n", "no column t"},
        {"t,fy\n1,nan\n", "fy = nan"}}) {
    options_.loads = Write("loads.csv", loads);
    EXPECT_THAT(Refusal(), HasSubstr(message));
  }
  options_.sensor = true;
  EXPECT_THAT(Refusal(), HasSubstr("--sensor, --loads"));
}

TEST_F(VerifyFilesTest, ARecordWithoutAForceIsReported) {
  options_.states = Write("states.csv",
                          "t,tip_x,tip_y,tip_z,fx,fy,fz,sigma,validity,true_fx,true_fy,true_fz\n"
                          "0,0,0,0,,,,,tracking_lost,0,1,0\n1,0,0,0,,,,,tracking_lost,0,2,0\n");
  options_.sensor = true;
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Report().dump(), HasSubstr("no state has a force"));
  options_.sensor = false;
  options_.loads = Write("loads.csv", "t,fx,fy,fz\n0,0,1,0\n1,0,2,0\n");
  EXPECT_EQ(Run(), 1);
  EXPECT_THAT(Report().dump(), HasSubstr("no state has a force"));
}

// The table that a run makes is one that --forces reads, with and without its scene.
TEST_F(VerifyFilesTest, ARunKeepsItsTableOfForces) {
  std::string states = "t,tip_x,tip_y,tip_z,fx,fy,fz,sigma,validity,true_fx,true_fy,true_fz\n";
  for (int i = 0; i < 200; ++i) {
    const double t = 0.02 * i, f = 1 + std::sin(6 * t), g = 0.5 * std::sin(2 * t);
    states += Formatted("%g,0.04,0.08,0,%.9g,%.9g,0,0.05,%s,%.9g,%.9g,0\n", t, 1.2 * g, 1.2 * f,
                        i == 7 ? "stale" : "valid", g, f);
  }
  options_.states = Write("states.csv", states);
  options_.sensor = true;
  EXPECT_EQ(Run(), 1);
  const auto report = Report();
  EXPECT_EQ(report["cards"][0]["flagged"], 1);
  EXPECT_EQ(Verdict("magnitude"), "wrong");
  const std::filesystem::path scene = options_.scene, forces = options_.out / "forces.csv";
  options_ = {.scene = scene, .forces = forces, .out = folder_ / "again"};
  EXPECT_EQ(Run(), 1);
  EXPECT_EQ(Report()["cards"], report["cards"]);
  options_.scene.clear();
  EXPECT_EQ(Run(), 1);
  EXPECT_EQ(Verdict("magnitude"), "wrong");
  EXPECT_THAT(LikelyWrong(), Not(HasSubstr("young_modulus")));
  options_.forces = Write("t.csv", "t,measured_fz,estimated_fz\n0,1,1\n1,2,2\n0.5,3,3\n");
  EXPECT_THAT(Refusal(), HasSubstr("t.csv:4: t falls from 1 to 0.5 s"));
  options_.forces = Write("t.csv", "t,measured_fz,estimated_fz\n1762000000000000000,1,1\n");
  EXPECT_THAT(Refusal(),
              HasSubstr("t.csv:2: t = 1762000000000000000: expected a time in the unit"));
}

// The samples are right: the report must not say that the slave refuses them.
TEST_F(VerifyFilesTest, AFullDiskIsNotReportedAsInvalidInput) {
  std::filesystem::create_directories(options_.out);
  std::filesystem::create_symlink("/dev/full", options_.out / "states.csv");
  options_.loads = Write("loads.csv", "t,fx,fy,fz\n0,0,1,0\n");
  EXPECT_THAT(Refusal(), HasSubstr("states.csv: cannot be written: No space left on device"));
}

TEST_F(VerifyFilesTest, ATipBesideTheKnownOneIsNamed) {
  for (const double beside : {0.0, 3.0}) {  // [mm]
    std::string states = "t,tip_x,tip_y,tip_z,fx,fy,fz,sigma,validity\n", loads;
    loads = "t,fx,fy,fz,x,y,z\n";
    for (int i = 0; i < 60; ++i) {
      const double t = 0.02 * i, f = 1 + std::sin(6 * t), y = 0.08 - 0.002 * f;
      states += Formatted("%g,%g,%g,0,0,%g,0,0.05,valid\n", t, 0.044 + 1e-3 * beside, y, f);
      loads += Formatted("%g,0,%g,0,0.044,%g,0\n", t, f, y);
    }
    options_.states = Write("states.csv", states);
    options_.loads = Write("loads.csv", loads);
    EXPECT_EQ(Run(), beside > 0 ? 1 : 0) << Report().dump(1);
    EXPECT_EQ(Verdict("place"), beside > 0 ? "wrong" : "right");
    if (beside > 0) EXPECT_THAT(LikelyWrong(), HasSubstr("The tip is 3 mm beside"));
  }
}

// A record of any source: presses along z with some x and y, errors of 0.02 N.
class VerifyForcesTest : public FolderTest {
 protected:
  struct Row {
    double t = 0;
    Vector3d measured, estimated;
  };
  VerifyForcesTest() { options_.out = folder_ / "card"; }
  template <class Corrupt>
  nlohmann::json CardOf(const Corrupt& corrupt, const std::string& head = kHead) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0, 0.02);
    std::string text = head;
    for (int i = 0; i < 1000; ++i) {
      Row row{0.01 * i, ForceAt(0.01 * i), ForceAt(0.01 * i)};
      corrupt(&row);
      for (double& x : row.estimated) x += normal(random);
      text += Formatted("%g,%g,%g,%g,%g,%g,%g,0.02\n", row.t, row.measured.x(), row.measured.y(),
                        row.measured.z(), row.estimated.x(), row.estimated.y(), row.estimated.z());
    }
    options_.forces = Write("forces.csv", text);
    code_ = RunVerify(options_, {});
    return nlohmann::json::parse(Scratch::Read(options_.out / "report.json"))["cards"][0];
  }
  static Vector3d ForceAt(double t) {
    return {0.6 * std::sin(2.1 * t), 0.6 * std::cos(1.3 * t), -1.5 + 1.4 * std::cos(3.1 * t)};
  }
  static std::string WrongOf(const nlohmann::json& card) {
    std::string wrong;
    for (const auto& [key, line] : card["lines"].items()) {
      if (line["verdict"] == "wrong") wrong += key + " ";
    }
    return wrong;
  }

  static constexpr const char* kHead =
      "t,measured_fx,measured_fy,measured_fz,estimated_fx,estimated_fy,estimated_fz,sigma\n";
  VerifyOptions options_;
  int code_ = -1;
};

TEST_F(VerifyForcesTest, ARightSourcePasses) {
  const auto card = CardOf([](Row*) {});
  EXPECT_EQ(WrongOf(card), "") << card.dump(1);
  EXPECT_EQ(code_, 0);
}

TEST_F(VerifyForcesTest, EachMistakeIsNamedAlone) {
  auto card = CardOf([](Row* row) { row->estimated = ForceAt(row->t - 0.15); });
  EXPECT_EQ(WrongOf(card), "delay ") << card.dump(1);
  EXPECT_NEAR(card["lines"]["delay"]["low_value_high"][1], 0.15, 0.005);
  card = CardOf([](Row* row) { row->estimated *= 1.3; });
  EXPECT_EQ(WrongOf(card), "magnitude sigma ") << card.dump(1);
  card = CardOf([](Row* row) { row->estimated *= 9.80665; });
  EXPECT_EQ(WrongOf(card), "unit ") << card.dump(1);
  EXPECT_NEAR(card["unit"], 9.80665, 1e-6);
  card = CardOf([](Row* row) { row->estimated.z() += 0.09 * row->t; });
  EXPECT_EQ(WrongOf(card), "sigma time ") << card.dump(1);
  EXPECT_NEAR(card["lines"]["time"]["low_value_high"][1], 0.9, 0.05);
  card = CardOf([](Row* row) { row->estimated.x() += 0.4; });
  EXPECT_EQ(WrongOf(card), "sigma zero ") << card.dump(1);
  card = CardOf([](Row* row) { row->estimated.y() *= -1; });
  EXPECT_EQ(WrongOf(card), "sigma sign ") << card.dump(1);
}

TEST_F(VerifyForcesTest, ATableWithoutRowsOrWithoutStampsIsRefused) {
  options_.forces = Write("empty.csv", kHead);
  EXPECT_THAT(Thrown<InputError>([&] { RunVerify(options_, {}); }),
              HasSubstr("empty.csv:1: no row: expected one per instant"));
  options_.forces =
      Write("zero.csv", std::string(kHead) + "0,1,0,0,1,0,0,0.1\n0,1,0,0,1,0,0,0.1\n" +
                            "1700000000.5,1,0,0,1,0,0,0.1\n");
  EXPECT_THAT(Thrown<InputError>([&] { RunVerify(options_, {}); }),
              HasSubstr("zero.csv:4: t jumps from 0 to 1700000000 s: expected rows of one clock"));
}

TEST_F(VerifyForcesTest, OtherNamesAndUnitsAreOptions) {
  options_.columns = {.measured = "-,-,scale",
                      .estimated = "-,-,net",
                      .time = "ms",
                      .sigma = "s",
                      .measured_unit = "g",
                      .time_unit = "ms"};
  const auto card = CardOf(
      [](Row* row) {
        row->t *= 1000;
        row->measured.z() *= 1000 / 9.80665;
      },
      "ms,a,b,scale,c,d,net,s\n");
  EXPECT_EQ(WrongOf(card), "") << card.dump(1);
  options_.columns.measured = "none";
  EXPECT_THAT(Thrown<InputError>([&] { RunVerify(options_, {}); }),
              HasSubstr("forces.csv:1: no column none"));
  options_.columns.measured_unit = "stone";
  EXPECT_THAT(Thrown<std::invalid_argument>([&] { RunVerify(options_, {}); }),
              HasSubstr("--measured-unit = stone: expected N"));
}

}  // namespace
}  // namespace palpate
