// `palpate-slave verify` on set-ups whose fault is known. The truth is what the test put in: known
// loads, a map that the set-up applies to them, and errors of the size that its sigma states.
#include "slave/commands/verify/verify.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <random>
#include <string>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"
#include "slave/commands/verify/card_report.h"
#include "slave/commands/verify/force_card.h"
#include "slave/live/offline_run.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::HasSubstr;
using testing::IsEmpty;

// Camera: planar, presses along y with some x. Plate: along z only. Fingertips: every direction.
enum class Sensor { kCamera, kPlate, kFingertips };
constexpr std::array kSensors{Sensor::kCamera, Sensor::kPlate, Sensor::kFingertips};

struct Fault {
  Matrix3d map = Matrix3d::Identity();  // reported = map * known
  double position_scale = 1;
  double sigma_scale = 1;
  Vector3d offset = Vector3d::Zero();  // [N]
};

SetUp SetUpOf(Sensor sensor) {
  if (sensor == Sensor::kCamera) return {true, false, 127e3, 0.35e-3, "the scale of the pixels"};
  if (sensor == Sensor::kPlate) return {false, false, 27e6, 0, "the encoders"};
  return {false, true, 0, 0, "the encoders or the poses of the fingertips"};
}

// Fourteen loads that are held, and three pauses without one. Errors: 2 % common to all loads, 2 %
// of each load, 1 % of each state, as sigma states them.
std::vector<MatchedState> Session(Sensor sensor, unsigned seed, const Fault& fault) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> size(0.3, 2.5);
  const auto noise = [&] {
    const double x = normal(random), y = normal(random), z = normal(random);
    Vector3d n(x, y, sensor == Sensor::kCamera ? 0 : z);
    return sensor == Sensor::kFingertips ? Vector3d(n / std::sqrt(3.0)) : n;
  };
  const double common = 0.02 * normal(random);
  std::vector<MatchedState> session;
  for (int load = 0; load < 17; ++load) {
    Vector3d direction = Vector3d::UnitZ();
    if (sensor == Sensor::kCamera) direction = {0.5 * normal(random), 1, 0};
    if (sensor == Sensor::kFingertips) direction = noise();
    const Vector3d known =
        load % 6 == 0 ? Vector3d(0, 0, 0) : Vector3d(size(random) * direction.normalized());
    const double force = known.norm();
    const Vector3d of_load = 0.02 * force * noise();
    const Vector3d place(0.001 * load, -0.002 * force,
                         sensor == Sensor::kCamera ? 0 : 0.001 * force);
    for (int i = 0; i < 20; ++i) {
      MatchedState one;
      one.load = load;
      one.known.force = known;
      one.known.p_S_tip = place;
      one.state.t = load + 0.05 * i;
      one.state.force =
          (1 + common) * (fault.map * known) + of_load + 0.01 * force * noise() + fault.offset;
      one.state.p_S_tip = Vector3d(0.01, 0.02, 0) + fault.position_scale * place + 5e-6 * noise();
      one.state.sigma = fault.sigma_scale * 0.03 * force;
      one.state.is_valid = true;
      session.push_back(one);
    }
  }
  return session;
}

ForceCard CardOf(Sensor sensor, unsigned seed, const Fault& fault = {}) {
  return MakeCard("", Session(sensor, seed, fault), SetUpOf(sensor));
}

std::string Causes(const ForceCard& card) {
  std::string all;
  for (const std::string& cause : card.causes) all += cause + "\n";
  return all;
}

Finding FindingOf(const ForceCard& card, const char* key) {
  return card.line(key).finding;
}

// Tolerance: 5 % of the cards, which is what intervals of 95 % permit.
TEST(VerifyTest, ACorrectSetUpPassesWithEverySensor) {
  for (const Sensor sensor : kSensors) {
    constexpr unsigned kSeeds = 60;
    unsigned alarms = 0;
    for (unsigned seed = 1; seed <= kSeeds; ++seed) {
      const ForceCard card = CardOf(sensor, seed);
      if (!card.passes()) ++alarms;
      if (!card.passes()) std::puts(ToText({card}).c_str());
    }
    EXPECT_LE(alarms, kSeeds * 5 / 100) << static_cast<int>(sensor);
  }
}

Fault Mapped(const Matrix3d& map, double position_scale = 1) {
  return {.map = map, .position_scale = position_scale};
}
Matrix3d Swap() {
  Matrix3d swap = Matrix3d::Zero();
  swap(0, 1) = swap(1, 0) = swap(2, 2) = 1;
  return swap;
}

// What a fault makes wrong on the card, what it leaves right, and a part of the cause that is
// named.
struct KnownFault {
  const char* name;
  std::vector<Sensor> sensors;
  Fault fault;
  const char* wrong;
  std::string right;
  const char* cause;
};
void PrintTo(const KnownFault& fault, std::ostream* out) {
  *out << fault.name;
}

class KnownFaultTest : public testing::TestWithParam<KnownFault> {};

TEST_P(KnownFaultTest, IsFoundWithItsCauseAndNothingElse) {
  const KnownFault& known = GetParam();
  for (const Sensor sensor : known.sensors) {
    for (unsigned seed = 1; seed <= 8; ++seed) {
      const ForceCard card = CardOf(sensor, seed, known.fault);
      EXPECT_EQ(FindingOf(card, known.wrong), Finding::kWrong) << ToText({card});
      std::istringstream right(known.right);
      for (std::string key; right >> key;) {
        EXPECT_EQ(FindingOf(card, key.c_str()), Finding::kRight) << key << "\n" << ToText({card});
      }
      EXPECT_THAT(Causes(card), HasSubstr(known.cause));
      if (known.fault.position_scale != 1) {  // the force follows the depth, so that it is scaled
        EXPECT_THAT(Causes(card), Not(HasSubstr("young_modulus")));
      }
    }
  }
}

const std::vector<Sensor> kEvery(kSensors.begin(), kSensors.end());
const std::vector<Sensor> kWithModulus{Sensor::kCamera, Sensor::kPlate};
const std::vector<Sensor> kOneCamera{Sensor::kCamera};
const std::vector<Sensor> kSeveralAxes{Sensor::kCamera, Sensor::kFingertips};
const Matrix3d kOne = Matrix3d::Identity();
const KnownFault kFaults[] = {
    {"SoftModulus", kWithModulus, Mapped(0.8 * kOne), "magnitude", "sign frame position",
     "object.material.young_modulus"},
    {"StiffModulus", kWithModulus, Mapped(1.2 * kOne), "magnitude", "sign frame position",
     "object.material.young_modulus"},
    {"ReversedSign", kEvery, Mapped(-kOne), "sign", "magnitude frame",
     "The sign is reversed on every axis"},
    {"SwappedAxes", kSeveralAxes, Mapped(Swap()), "frame", "magnitude",
     "known x is reported as y, known y is reported as x"},
    {"SmallPixels", kOneCamera, Mapped(0.97 * kOne, 0.97), "position", "", "sense.camera.pixel"},
    {"LargePixels", kOneCamera, Mapped(1.03 * kOne, 1.03), "position", "", "sense.camera.pixel"},
};
INSTANTIATE_TEST_SUITE_P(Faults, KnownFaultTest, testing::ValuesIn(kFaults),
                         [](const auto& tested) { return std::string(tested.param.name); });

TEST(VerifyTest, ASigmaThatIsTooSmallIsFound) {
  for (const Sensor sensor : kEvery) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      const ForceCard card = CardOf(sensor, seed, {.sigma_scale = 0.2});
      EXPECT_EQ(FindingOf(card, "sigma"), Finding::kWrong) << ToText({card});
      EXPECT_EQ(FindingOf(card, "magnitude"), Finding::kRight);
      EXPECT_THAT(Causes(card), HasSubstr("Only sigma is wrong"));
    }
  }
}

TEST(VerifyTest, APixelScaleAndAModulusAreFoundTogether) {
  const ForceCard card =
      CardOf(Sensor::kCamera, 1, {.map = 1.3 * Matrix3d::Identity(), .position_scale = 1.03});
  EXPECT_THAT(Causes(card), HasSubstr("sense.camera.pixel"));
  EXPECT_THAT(Causes(card), HasSubstr("young_modulus"));
}

// The map of fingertips: a random permutation with random signs, and a gain for each axis.
TEST(VerifyTest, RandomPermutationsSignsAndGainsAreNamed) {
  for (unsigned seed = 1; seed <= 24; ++seed) {
    std::mt19937 random(1000 + seed);
    std::array<int, 3> axis{0, 1, 2}, sign{1, 1, 1};
    std::shuffle(axis.begin(), axis.end(), random);
    Matrix3d map = Matrix3d::Zero();
    Vector3d gain;
    for (int j = 0; j < 3; ++j) {
      const auto i = static_cast<std::size_t>(j);
      sign[i] = random() % 2 == 0 ? 1 : -1;
      gain(j) = std::array{0.7, 1.0, 1.35}[random() % 3];
      map(axis[i], j) = sign[i] * gain(j);
    }
    const ForceCard card = CardOf(Sensor::kFingertips, seed, {.map = map});
    EXPECT_EQ(card.force.relation.axis, axis) << ToText({card}) << map;
    EXPECT_EQ(card.force.relation.sign, sign) << ToText({card}) << map;
    const bool is_flipped = std::accumulate(sign.begin(), sign.end(), 0) < 3;
    EXPECT_EQ(FindingOf(card, "sign") == Finding::kWrong, is_flipped) << ToText({card}) << map;
    EXPECT_EQ(FindingOf(card, "frame") == Finding::kWrong, card.force.relation.is_permuted());
    for (int j = 0; j < 3; ++j) {
      const auto& of_axis = card.force.axis_gain[static_cast<std::size_t>(j)];
      ASSERT_TRUE(of_axis);
      EXPECT_NEAR(of_axis->value, gain(j), 0.08 * gain(j)) << map;
    }
    const bool is_scaled = (gain.array() != 1).any();
    EXPECT_EQ(FindingOf(card, "magnitude") == Finding::kWrong, is_scaled) << ToText({card}) << map;
  }
}

TEST(VerifyTest, ARotatedFrameIsFoundWithItsAngle) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const Vector3d about = Vector3d(normal(random), normal(random), normal(random)).normalized();
    const Matrix3d turn = Eigen::AngleAxisd(0.35, about).matrix();
    const ForceCard card = CardOf(Sensor::kFingertips, seed, {.map = turn});
    EXPECT_EQ(FindingOf(card, "frame"), Finding::kWrong) << ToText({card});
    EXPECT_EQ(FindingOf(card, "magnitude"), Finding::kRight) << ToText({card});
    EXPECT_EQ(FindingOf(card, "sign"), Finding::kRight) << ToText({card});
    EXPECT_NEAR(card.force.turn.value, 0.35, 0.05);
  }
}

TEST(VerifyTest, AForceWithoutALoadIsFoundAndDoesNotCountAsAScale) {
  const ForceCard card = CardOf(Sensor::kFingertips, 1, {.offset = {0.4, 0, 0.3}});
  EXPECT_EQ(FindingOf(card, "zero"), Finding::kWrong);
  EXPECT_EQ(FindingOf(card, "magnitude"), Finding::kRight) << ToText({card});
  EXPECT_THAT(Causes(card), HasSubstr("without a load"));
}

TEST(VerifyTest, ADeadSensorIsFound) {
  for (const Sensor sensor : kSensors) {
    auto session = Session(sensor, 1, {});
    for (auto& one : session) one.state.force.setZero();
    const ForceCard card = MakeCard("", session, SetUpOf(sensor));
    EXPECT_EQ(FindingOf(card, "magnitude"), Finding::kWrong) << ToText({card});
    EXPECT_THAT(Causes(card), HasSubstr("No force is reported under load"));
  }
}

TEST(VerifyTest, FewLoadsDecideNothing) {
  auto session = Session(Sensor::kFingertips, 1, {});
  std::erase_if(session, [](const MatchedState& one) { return one.load > 3; });
  const ForceCard card = MakeCard("", session, SetUpOf(Sensor::kFingertips));
  EXPECT_EQ(FindingOf(card, "magnitude"), Finding::kOpen) << ToText({card});
  EXPECT_FALSE(card.passes());
}

// Numbers that are not finite are unknown, never a verdict.
TEST(VerifyTest, UnknownForcesAreLeftOut) {
  auto session = Session(Sensor::kCamera, 1, {});
  for (std::size_t i = 0; i < session.size(); i += 3) session[i].state.force = kUnknownVector3;
  EXPECT_TRUE(MakeCard("", session, SetUpOf(Sensor::kCamera)).passes());
  for (auto& one : session) one.state.force = kUnknownVector3;
  const ForceCard card = MakeCard("", session, SetUpOf(Sensor::kCamera));
  EXPECT_EQ(FindingOf(card, "magnitude"), Finding::kUntested);
  EXPECT_FALSE(card.passes());
}

TEST(VerifyTest, LoadsAreReadAsPeopleDescribeThem) {
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

// The simulated block, whose recorded images are processed again with another scene: the whole way
// from images to the card. Loads and positions are those of the simulator.
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
    std::vector<KnownLoad> loads;
    for (const ReportedState& state : ReadStates(folder_ / name / "states.csv")) {
      loads.push_back({.from = state.t, .force = state.measured, .p_S_tip = state.p_S_tip});
    }
    std::string table = "t,fx,fy,fz,x,y,z\n";
    for (const KnownLoad& load : loads) {
      table += Formatted("%.6f,%.9g,%.9g,0,%.9g,%.9g,0\n", load.from, load.force.x(),
                         load.force.y(), load.p_S_tip.x(), load.p_S_tip.y());
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

    // More than that: the slave refuses the images.
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

TEST_F(VerifyFilesTest, StatesKeepTheirValidity) {
  const std::string text = "t,fx,fy,fz,sigma,validity\n0,0,1,0,0.1,valid\n1,,,,,stale\n";
  WriteStates(ReadStates(Write("states.csv", text)), folder_ / "again.csv");
  const auto again = ReadStates(folder_ / "again.csv");
  ASSERT_EQ(again.size(), 2U);
  EXPECT_EQ(again[0].validity, "valid");
  EXPECT_EQ(again[1].validity, "stale");
  EXPECT_FALSE(again[1].is_valid);
}

// The samples are right: the report must not say that the slave refuses them.
TEST_F(VerifyFilesTest, AFullDiskIsNoRefusal) {
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
