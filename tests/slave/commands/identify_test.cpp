// `palpate-slave identify` end to end: tables in, report and drawing out, and what it refuses.
#include "slave/commands/identify/identify.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/commands/solve/solve.h"
#include "slave/pipeline/offline/offline_run.h"
#include "slave/scene/scene_loader.h"
#include "tests/support/paths.h"

namespace palpate {
namespace {

using nlohmann::json;
using std::filesystem::path;
using testing::HasSubstr;

class IdentifyCommand : public testing::Test {
 protected:
  IdentifyCommand() { std::filesystem::create_directories(folder_); }

  path Write(const std::string& name, const std::string& text) {
    WriteWholeFile(folder_ / name, text);
    return folder_ / name;
  }
  json Run(IdentifyOptions options) {
    options.out = folder_ / "out";
    EXPECT_EQ(RunIdentify(options, {}), 0);
    std::ifstream stream(options.out / "report.json");
    return json::parse(stream);
  }
  std::string Refusal(IdentifyOptions options) {
    options.out = folder_ / "refused";
    try {
      RunIdentify(options, {});
    } catch (const std::exception& e) {
      return e.what();
    }
    return {};
  }

  path folder_ = BinaryPath("/identify-command");
};

// A neo-Hookean rubber of 0.3 MPa: the law, its modulus, and lines of a scene.
TEST_F(IdentifyCommand, TellsALawItsModulusAndTheScenesLines) {
  std::string text = "stretch,P_MPa\n";
  for (int i = 1; i <= 30; ++i) {
    const double l = 1 + 0.03 * i;
    text += Formatted("%.4f,%.9f\n", l, 0.3 * (l - 1 / (l * l)));
  }
  const json report = Run({.data = {"tension=" + Write("rubber.csv", text).string()}});
  EXPECT_EQ(report.at("best"), "neo-hookean");
  EXPECT_NEAR(report.at("laws").at(0).at("shear_modulus_Pa").get<double>(), 3e5, 30);
  EXPECT_THAT(report.at("laws").at(0).at("scene").get<std::string>(), HasSubstr("law: ogden"));
  EXPECT_GT(std::filesystem::file_size(folder_ / "out" / "identify.svg"), 2000U);
  EXPECT_GT(std::filesystem::file_size(folder_ / "out" / "predictions.csv"), 1000U);
}

// A simulated block pressed by `solve` is measured from another start: E and nu within 2 %.
TEST_F(IdentifyCommand, FindsASimulatedBlockAgain) {
  const auto scene = [&](const char* name, const char* E, const char* nu) {
    return Write(name, std::string("name: block\nobject:\n  geometry: {box: {size: [0.06, 0.06, "
                                   "0.03], cells: [6, 6, 3]}}\n  material: {young_modulus: ") +
                           E + ", poisson_ratio: " + nu +
                           "}\n  fixed: {plane: {axis: z, at: 0 m}}\nmodel: {kind: fem}\n");
  };
  const path truth = scene("truth.yaml", "23.7 kPa", "0.33");
  const path contacts = Write("contacts.csv",
                              "case,x,y,z,dx,dy,dz,width\n"
                              "a,0.03,0.03,0.03,0,0,-0.003,0.02\n"
                              "b,0.02,0.03,0.03,0.001,0,-0.002,0.02\n"
                              "c,0.03,0.03,0.03,0,0,-0.006,0.05\n");
  ASSERT_EQ(RunSolve({.scene = truth, .contacts = contacts, .out = folder_ / "answers.csv"}), 0);
  // As `solve` writes it, without widths: they are put back.
  std::ifstream answers(folder_ / "answers.csv");
  std::string with_widths, line;
  for (int row = 0; std::getline(answers, line); ++row) {
    with_widths += line + (row == 0 ? ",width\n" : row == 3 ? ",0.05\n" : ",0.02\n");
  }
  const path start = scene("start.yaml", "5 kPa", "0.2");
  const json report = Run({.data = {"press=" + Write("presses.csv", with_widths).string()},
                           .scene = start,
                           .fit_poisson = true});
  EXPECT_NEAR(report.at("press").at("young_modulus_Pa").get<double>() / 23700, 1, 0.02);
  EXPECT_NEAR(report.at("press").at("poisson_ratio").get<double>(), 0.33, 0.01);
}

TEST_F(IdentifyCommand, RefusesWithASentence) {
  const std::string table = Write("t.csv", "strain,stress\n0,0\n.1,1\n.2,2\n.3,3\n").string();
  EXPECT_THAT(Refusal({.data = {"tension=" + table}, .ends = "glued"}), HasSubstr("--ends"));
  EXPECT_THAT(Refusal({.data = {"press=" + table}}), HasSubstr("--scene"));
  EXPECT_THAT(Refusal({.data = {"biaxial:x=" + table}}), HasSubstr("second strain"));
  EXPECT_THAT(Refusal({.data = {"tension=" + table}, .stress_unit = "bar"}),
              HasSubstr("--stress-unit"));
  EXPECT_THAT(Refusal({.data = {"tension=" + table}, .height = "3 kg"}), HasSubstr("--height"));
  EXPECT_THAT(Refusal({.data = {"tension=absent.csv"}}), HasSubstr("cannot be read"));
  EXPECT_THAT(Refusal({.data = {table}}), HasSubstr("F11"));
}

// A block of 127 kPa, pressed before a camera, its true force known: the modulus comes out of the
// pictures, whatever the scene says of it. Tolerance: what model and eyes are off by in the force.
TEST_F(IdentifyCommand, PicturesAndAKnownForceTellTheModulus) {
  const path block = SourcePath("/deploy/scenes/silicone-block.yaml");
  const path out = folder_ / "block";
  RunOffline(LoadScene(block, {"operator.press={depth: 4 mm, speed: 40 mm/s}"}),
             {.out = out, .frames = true}, {});
  std::string forces = "sequence,fx,fy,fz\n";
  CsvRows states(out / "states.csv");
  const auto column = [&](const char* name) { return *states.Find(name); };
  while (states.Next()) {
    forces +=
        Formatted("%.0f,%.6f,%.6f,0\n", states.Number(column("sequence"), 1e9),
                  states.Number(column("true_fx"), 1e9), states.Number(column("true_fy"), 1e9));
  }
  IdentifyOptions options;
  options.data = {"pictures=" + Write("forces.csv", forces).string()};
  options.scene = block;
  options.overrides = {"sense.camera={file: '" + (out / "frames/%06d.png").string() +
                           "', pixel: 0.35 mm, pose: {translation: [44 mm, 54 mm, 0]}}",
                       "object.material.young_modulus=60 kPa"};
  const json fit = Run(options).at("pictures");
  EXPECT_NEAR(fit.at("young_modulus_Pa").get<double>(), 127e3, 0.015 * 127e3);
  EXPECT_GT(fit.at("sigma_Pa").get<double>(), 0);
  EXPECT_GT(fit.at("pressed").get<int>(), 20);
}

TEST_F(IdentifyCommand, SaysWhatForcesOfPicturesMustBe) {
  const auto refusal = [&](const std::string& text, bool recorded = true) {
    IdentifyOptions options;
    options.data = {"pictures=" + Write("forces.csv", text).string()};
    options.scene = SourcePath("/deploy/scenes/silicone-block.yaml");
    const std::string picture = Write("1.png", "not looked at").string();
    if (recorded) options.overrides = {"sense.camera={file: '" + picture + "', pixel: 0.35 mm}"};
    return Refusal(options);
  };
  EXPECT_THAT(refusal("a,b\n1,2\n"), HasSubstr("forces.csv:1: no column force"));
  EXPECT_THAT(refusal("sequence,force\n1,2\n1,3\n"), HasSubstr(":3: sequence: accepted is each"));
  EXPECT_THAT(refusal("sequence,force\n1.5,2\n"), HasSubstr(":2: sequence: accepted is a whole"));
  EXPECT_THAT(refusal("force\n1\n", false), HasSubstr("accepted is a scene with recorded"));
  EXPECT_THAT(Refusal({.data = {"pictures=forces.csv"}}), HasSubstr("needs --scene"));
}

}  // namespace
}  // namespace palpate
