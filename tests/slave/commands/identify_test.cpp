// Tests `palpate-slave identify` as a whole: input tables, report, and refused input.
#include "slave/commands/identify/identify.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "shared/text/csv.h"
#include "shared/text/text.h"
#include "slave/commands/solve/solve.h"
#include "slave/identify/identify_report.h"
#include "slave/live/offline_run.h"
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
  json Run(IdentifyRequest request) {
    const IdentifyOptions options{std::move(request), folder_ / "out"};
    EXPECT_EQ(RunIdentify(options, {}), 0);
    std::ifstream stream(options.out / "report.json");
    return json::parse(stream);
  }
  std::string Refusal(IdentifyRequest request) {
    const IdentifyOptions options{std::move(request), folder_ / "refused"};
    try {
      RunIdentify(options, {});
    } catch (const std::exception& e) {
      return e.what();
    }
    return {};
  }

  path folder_ = BinaryPath("/identify-command");
};

// Can be checked by hand: 0.2 N/mm2 on 100 mm2 are 20 N, and the same on 10 mm x 10 mm.
TEST(IdentifyReading, IsAForceAndItsWeight) {
  identify::MaterialTest test{.name = "pad", .components = {{0, 0}}};
  test.rows = {{.abscissa = 1, .measured = {0}}, {.abscissa = 0.75, .measured = {-2e5}}};
  EXPECT_EQ(
      ReadingOf(test),
      "pad: read as a compression of up to 25 %, where a square of 10 mm bears 20 N, the weight "
      "of 2039 g. If that is not so, a unit or a size is wrong");
  test.area = 5e-4;
  test.rows.back().abscissa = 1.5;
  EXPECT_THAT(ReadingOf(test),
              HasSubstr("a strain of up to 50 %, where the specimen bears 1e+02 N, "
                        "the weight of 10194 g"));
}

// A neo-Hookean rubber of 0.3 MPa: the law, its modulus, and lines of a scene.
TEST_F(IdentifyCommand, PrintsALawItsModulusAndTheScenesLines) {
  std::string text = "stretch,P_MPa\n";
  for (int i = 1; i <= 30; ++i) {
    const double l = 1 + 0.03 * i;
    text += Formatted("%.4f,%.9f\n", l, 0.3 * (l - 1 / (l * l)));
  }
  const json report = Run({.data = {"tension=" + Write("rubber.csv", text).string()}});
  EXPECT_EQ(report.at("best"), "neo-hookean");
  EXPECT_NEAR(report.at("laws").at(0).at("shear_modulus_Pa").get<double>(), 3e5, 30);
  EXPECT_THAT(report.at("laws").at(0).at("scene").get<std::string>(), HasSubstr("law: ogden"));
}

// Puts the scene lines of a fit into a scene and loads it with `LoadScene`.
Scene SceneOf(const path& folder, const std::string& lines) {
  WriteWholeFile(folder / "base.yaml",
                 "name: block\nobject:\n  geometry: {box: {size: [0.06, 0.06, 0.03], cells: [6, 6, "
                 "3]}}\n  material: {young_modulus: 1 kPa, poisson_ratio: 0.3}\n  fixed: {plane: "
                 "{axis: z, at: 0 m}}\nmodel: {kind: fem}\n");
  std::vector<std::string> overrides;
  std::istringstream stream(lines);
  for (std::string line; std::getline(stream, line);) {
    line.erase(0, 2);
    overrides.push_back(line.replace(line.find(": "), 2, "="));
  }
  EXPECT_EQ(overrides.size(), 2U) << lines;
  return LoadScene(folder / "base.yaml", overrides, SceneUse::kSolve);
}

// Lines of the law that a scene reads.
std::string SceneLinesOf(const json& report) {
  if (report.contains("relaxation")) return report.at("relaxation").at("scene");
  for (const json& law : report.at("laws")) {
    if (law.at("law") == report.at("scene_law")) return law.at("scene");
  }
  return {};
}

// Yeoh's law is the best of a rubber that stiffens, but no scene reads it; of a Prony series a
// scene reads the modulus at the end of the record, or all of it.
TEST_F(IdentifyCommand, GivesLinesThatASceneReadsForEveryTest) {
  std::string yeoh = "stretch,P_kPa\n", hold = "t_s,shear,stress_kPa\n";
  for (int i = 1; i <= 60; ++i) {
    const double l = 1 + 0.025 * i, beyond = l * l + 2 / l - 3, c = 0.5 - 0.7 * i / 60;
    yeoh += Formatted("%.4f,%.9f\n", l, 2 * (30 + 1.8 * beyond * beyond) * (l - 1 / (l * l)));
    hold += Formatted("%d,0.1,%.9f\n", i, 0.2 + 0.3 * std::exp(-i / 10.0) + 1e-4 * c);
  }
  json report = Run({.data = {"tension=" + Write("yeoh.csv", yeoh).string()}});
  EXPECT_THAT(report.at("best").get<std::string>(), HasSubstr("yeoh"));
  EXPECT_NE(report.at("scene_law"), report.at("best"));
  const Scene rubber = SceneOf(folder_, SceneLinesOf(report));
  EXPECT_EQ(rubber.model.kind, "fem");
  EXPECT_GT(rubber.object.material.young_modulus_tolerance, 0.04);  // the spread between specimens

  report = Run({.data = {"relaxation=" + Write("hold.csv", hold).string()}});
  const Scene adhesive = SceneOf(folder_, SceneLinesOf(report));
  EXPECT_NEAR(adhesive.object.material.young_modulus, 3 * 2000, 100);  // 3 G, of 0.2 kPa at 10 %
  // 2 (1 + nu) G of the first row, after 1 s; 0.2 kPa of it stay.
  const double first = 0.2e3 + 0.3e3 * std::exp(-0.1);
  const Material relaxing =
      SceneOf(folder_, report.at("relaxation").at("relaxing_scene")).object.material;
  EXPECT_NEAR(relaxing.young_modulus, 2 * (1 + relaxing.poisson_ratio) * first / 0.1, 150);
  double left = 1;
  for (const RelaxationTerm& term : relaxing.relaxation) left -= term.share;
  EXPECT_NEAR(left, 0.2e3 / first, 0.01);
}

TEST_F(IdentifyCommand, LeavesATableOfThreeRowsOut) {
  const std::string few = Write("few.csv", "stretch,P_kPa\n1,0\n1.1,3\n1.2,5\n").string();
  std::string text = "stretch,P_kPa\n";
  for (int i = 1; i <= 30; ++i) {
    const double l = 1 + 0.03 * i;
    text += Formatted("%.4f,%.9f\n", l, 30 * (l - 1 / (l * l)));
  }
  const json report = Run({.data = {"tension=" + few, "tension=" + Write("r.csv", text).string()}});
  EXPECT_THAT(report.at("warnings").at(0).get<std::string>(), HasSubstr("few.csv: 3 rows"));
  EXPECT_EQ(report.at("best"), "neo-hookean");
  EXPECT_THAT(Refusal({.data = {"tension=" + few}}), HasSubstr("expected 4 or more"));
}

// No law of the list falls and rises again.
TEST_F(IdentifyCommand, CallsNoPoorFitTheBest) {
  std::string text = "stretch,P_kPa\n";
  for (int i = 1; i <= 40; ++i)
    text += Formatted("%.4f,%.6f\n", 1 + 0.01 * i, i % 20 < 10 ? 9. : 3.);
  const json report = Run({.data = {"tension=" + Write("steps.csv", text).string()}});
  EXPECT_FALSE(report.contains("best"));
  EXPECT_TRUE(report.contains("closest"));
  SceneOf(folder_, SceneLinesOf(report));
}

// `file` with other words in its header and one column times `factor`.
std::string Altered(const path& file, const std::string& from, const std::string& to,
                    std::size_t column = 0, double factor = 1) {
  std::ifstream stream(file);
  std::string text;
  for (std::string line; std::getline(stream, line); text += '\n') {
    if (const std::size_t at = line.find(from); !from.empty() && at != std::string::npos) {
      line.replace(at, from.size(), to);
    }
    std::istringstream cells(line);
    std::size_t count = 0;
    for (std::string cell; std::getline(cells, cell, ','); ++count) {
      const auto number = ParseFinite(cell);
      if (count > 0) text += ',';
      text += number && count == column ? Formatted("%.9g", factor * *number) : cell;
    }
  }
  return text;
}

// Twenty-two wrong units on published data, each of which is accepted with the right unit; and a
// compression test that is declared as a relaxation. Without a scene, rubber in MPa that is
// declared as kPa cannot be detected, since it would be as soft as brain.
TEST_F(IdentifyCommand, RejectsWrongUnitsOfPublishedData) {
  const path data = SourcePath("/../shared/data");
  if (!std::filesystem::exists(data)) GTEST_SKIP() << data << " is absent";
  const path silicone = data / "silicone_compression/EF50_0T_A1.csv",
             rubber = data / "hyperelastic_curves/Treloar_1944/UT.csv",
             brain = data / "hyperelastic_curves/Budday_2017/UT_T_corona_radiata.csv",
             foam = data / "foam_curves/foam_leap/UC.csv",
             tension = data / "foam_curves/foam_leap/UT.csv",
             adhesive = data / "viscoelastic_adhesive/shear_relaxation_1.csv";
  const auto as = [&](const std::string& kind, const path& file) {
    return IdentifyRequest{.data = {kind + "=" + file.string()}};
  };
  const auto sized = [&](const path& file, const char* diameter, const char* height) {
    IdentifyRequest options = as("compression", file);
    options.diameter = diameter, options.height = height;
    return options;
  };
  const auto with = [](IdentifyRequest options, const char* unit) {
    options.stress_unit = unit;
    return options;
  };
  Run(sized(silicone, "50mm", "30mm"));
  Run(as("compression", silicone));
  Run(with(as("uniaxial", rubber), "MPa"));
  Run(with(as("uniaxial", brain), "kPa"));
  Run(as("compression", foam));
  Run(as("tension", tension));
  Run(as("relaxation", adhesive));
  const auto headed = [&](const char* name, const path& file, const char* from, const char* to) {
    return Write(name, Altered(file, from, to));
  };
  const auto silicones = [&](const char* name, const char* from, const char* to) {
    return headed(name, silicone, from, to);
  };
  IdentifyRequest against_scene = with(as("uniaxial", rubber), "kPa");
  against_scene.scene = SourcePath("/deploy/scenes/foam-cube.yaml");
  against_scene.overrides = {"object.material.young_modulus=1.2 MPa"};
  const std::vector<IdentifyRequest> wrong{
      sized(silicone, "50", "30"),
      sized(silicone, "50", "30mm"),
      sized(silicone, "50mm", "30"),
      sized(silicones("mN.csv", "Load (N)", "Load (mN)"), "50mm", "30mm"),
      sized(silicones("kN.csv", "Load (N)", "Load (kN)"), "50mm", "30mm"),
      sized(silicones("kgf.csv", "Load (N)", "Load (kgf)"), "50mm", "30mm"),
      sized(silicones("lbf.csv", "Load (N)", "Load (lbf)"), "50mm", "30mm"),
      sized(silicones("psi.csv", "Stress (kPa)", "Stress (psi)"), "50mm", "30mm"),
      sized(silicones("m.csv", "Compression (mm)", "Compression (m)"), "50mm", "30mm"),
      sized(silicones("in.csv", "Compression (mm)", "Compression (in)"), "50mm", "30mm"),
      sized(silicones("um.csv", "Compression (mm)", "Compression (um)"), "50mm", "30mm"),
      as("compression", silicones("Pa.csv", "Stress (kPa)", "Stress (Pa)")),
      as("compression", silicones("MPa.csv", "Stress (kPa)", "Stress (MPa)")),
      as("compression",
         silicones("fraction.csv", "Engineering Strain [-]", "Engineering Strain [%]")),
      as("compression", Write("percent.csv", Altered(silicone, "", "", 3, 100))),
      as("uniaxial", rubber),
      as("uniaxial", brain),
      with(as("uniaxial", brain), "GPa"),
      against_scene,
      as("compression", headed("foam.csv", foam, "P_MPa", "P_Pa")),
      as("tension", headed("GPa.csv", tension, "P_MPa", "P_GPa")),
      as("tension", Write("lambda.csv", Altered(tension, "", "", 0, 100)))};
  for (const IdentifyRequest& options : wrong) {
    const std::string refusal = Refusal(options);
    EXPECT_TRUE(refusal.find("Check the units") != std::string::npos ||
                refusal.find("stretch =") != std::string::npos ||
                refusal.find("expected a length, above 0, up to 2 m") != std::string::npos)
        << options.data.front() << " " << options.diameter << " " << options.height << ": "
        << refusal;
  }
  EXPECT_THAT(Refusal(as("relaxation", silicone)), HasSubstr("only rises, at one rate"));
}

// All four materials of the published data.
TEST_F(IdentifyCommand, GivesLinesThatASceneReadsForPublishedData) {
  const path data = SourcePath("/../shared/data");
  if (!std::filesystem::exists(data)) GTEST_SKIP() << data << " is absent";
  const auto expect = [&](const IdentifyRequest& options) {
    EXPECT_NO_THROW(SceneOf(folder_, SceneLinesOf(Run(options)))) << options.data.front();
  };
  for (const auto& entry : std::filesystem::directory_iterator(data / "silicone_compression")) {
    if (!entry.path().filename().string().ends_with("_A1.csv")) continue;
    IdentifyRequest options{.data = {"compression=" + entry.path().string()}};
    options.diameter = "50mm", options.height = "30mm", options.ends = "bonded";
    expect(options);
  }
  const std::string curves = (data / "hyperelastic_curves/").string(),
                    foam = (data / "foam_curves/foam_leap/").string(),
                    adhesive = (data / "viscoelastic_adhesive/").string();
  for (const std::string material : {"Treloar_1944", "Kawabata_1981", "Meunier_2008"}) {
    const std::string folder = curves + material;
    IdentifyRequest options{.data = {"uniaxial=" + folder + "/UT.csv",
                                     "equibiaxial=" + folder + "/ET.csv",
                                     "planar=" + folder + "/PS.csv"}};
    options.stress_unit = "MPa";
    expect(options);
    options.data = {folder + "/UT.csv"};  // tensor components
    expect(options);
  }
  IdentifyRequest gel{.data = {"biaxial=" + curves + "Katashima_2012/BT.csv"}};
  gel.stress_unit = "kPa";
  expect(gel);
  for (const char* kind : {"tension=UT", "compression=UC", "shear=SS"}) {
    const std::string word = kind;
    const std::size_t at = word.find('=') + 1;
    expect({.data = {word.substr(0, at) + foam + word.substr(at) + ".csv"}});
  }
  for (const char* file :
       {"shear_relaxation", "shear_relaxation_1", "loading_2d0_unloading_0d03"}) {
    expect({.data = {"relaxation=" + adhesive + file + ".csv"}});
  }
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
  const path answers = folder_ / "answers.csv";
  ASSERT_EQ(RunSolve({.scene = truth, .contacts = contacts, .out = answers}), 0);
  const path start = scene("start.yaml", "5 kPa", "0.2");
  const json report =
      Run({.data = {"press=" + answers.string()}, .scene = start, .fit_poisson = true});
  EXPECT_NEAR(report.at("press").at("young_modulus_Pa").get<double>() / 23700, 1, 0.02);
  EXPECT_NEAR(report.at("press").at("poisson_ratio").get<double>(), 0.33, 0.01);
}

// Of two contacts that act together only the second is on elements that are too coarse for it.
TEST_F(IdentifyCommand, CountsACaseWithAnyFlaggedRow) {
  const path scene = Write("cube.yaml",
                           "name: cube\nobject:\n  geometry: {box: {size: [0.06, 0.06, 0.06], "
                           "cells: [6, 6, 6]}}\n  material: {young_modulus: 4 kPa, "
                           "poisson_ratio: 0.15}\n  fixed: {plane: {axis: z, at: 0 m}}\n"
                           "model: {kind: fem-green}\n");
  const path contacts = Write("contacts.csv",
                              "case,x,y,z,dx,dy,dz,width\n"
                              "two,0.02,0.03,0.06,0,0,-0.001,0.03\n"
                              "two,0.058,0.03,0.06,0,0,-0.001,0.002\n"
                              "one,0.03,0.03,0.06,0,0,-0.001,0.04\n");
  const path answers = folder_ / "answers.csv";
  ASSERT_EQ(RunSolve({.scene = scene, .contacts = contacts, .out = answers}), 0);
  const json report = Run({.data = {"press=" + answers.string()}, .scene = scene});
  EXPECT_THAT(report.at("warnings").at(0).get<std::string>(),
              HasSubstr("1 of 2 cases are extrapolated, the first because the error of the mesh"));
}

// The force of a membrane has a part by its tension at rest and one by its modulus. The scene
// starts at half the modulus of the presses.
TEST_F(IdentifyCommand, FindsAMembranesModulusBesideItsTension) {
  const auto scene = [&](const char* name, const char* E) {
    return Write(name,
                 std::string("name: membrane\nobject:\n  geometry: {membrane: {radius: 39 "
                             "mm, thickness: 1 mm}}\n  material: {young_modulus: ") +
                     E +
                     ", poisson_ratio: 0.45}\n  fixed: {side: rim}\ntool: {width: 4 mm, load: "
                     "even}\nmodel: {kind: plate-large, prestress: 2000 N/m}\n");
  };
  const path contacts = Write("contacts.csv",
                              "case,x,y,z,dx,dy,dz\n"
                              "a,0,0,0,0,0,-0.001\nb,0,0,0,0,0,-0.002\nc,0,0,0,0,0,-0.003\n");
  ASSERT_EQ(RunSolve({.scene = scene("truth.yaml", "54.4 MPa"),
                      .contacts = contacts,
                      .out = folder_ / "answers.csv"}),
            0);
  const json fit = Run({.data = {"press=" + (folder_ / "answers.csv").string()},
                        .scene = scene("start.yaml", "27.2 MPa")})
                       .at("press");
  EXPECT_NEAR(fit.at("young_modulus_Pa").get<double>() / 54.4e6, 1, 1e-3);
}

// `identify` reads the contacts as `solve` does: the tool's width and roundness, units, columns.
class PressTable : public IdentifyCommand {
 protected:
  path Scene(const std::string& E, const std::string& tool) {
    return Write(
        "gel.yaml",
        "name: gel\nobject:\n  geometry: {box: {size: [40 mm, 40 mm, 20 mm], cells: [8, 8, "
        "4]}}\n  material: {young_modulus: " +
            E + ", poisson_ratio: 0.4}\n  fixed: {plane: {axis: z, at: 0 mm}}\n" + tool +
            "model: {kind: fem}\n");
  }
  std::string Press(const std::string& header, const std::string& row) {
    return "press=" + Write("press.csv", header + "\n" + row + "\n").string();
  }
  double Modulus(const path& scene, const std::string& data) {
    return Run({.data = {data}, .scene = scene}).at("press").at("young_modulus_Pa");
  }

  const std::string header_ = "case,x,y,z,dx,dy,dz,fx,fy,fz";
  const std::string row_ = "a,0.02,0.02,0.02,0,0,-0.001,0,0,-0.286";
};

// `identify` finds the modulus from the forces that `solve` computed under a round or flat tool.
TEST_F(PressTable, FindsTheModulusFromAnswersOfSolve) {
  const path contacts = Write("contacts.csv",
                              "case,x,y,z,dx,dy,dz\na,0.02,0.02,0.02,0,0,-0.001\n"
                              "b,0.02,0.02,0.02,0,0,-0.002\n");
  for (const char* tool : {"tool: {shape: flat, width: 12 mm}\n",
                           "tool: {shape: round, radius: 12 mm, width: 24 mm}\n"}) {
    const path answers = folder_ / "answers.csv";
    ASSERT_EQ(RunSolve({.scene = Scene("20 kPa", tool), .contacts = contacts, .out = answers}), 0);
    EXPECT_NEAR(Modulus(Scene("9 kPa", tool), "press=" + answers.string()) / 20e3, 1, 1e-3) << tool;
    // The answers contain width or radius: the tool of the second scene does not matter.
    EXPECT_NEAR(Modulus(Scene("9 kPa", ""), "press=" + answers.string()) / 20e3, 1, 1e-3) << tool;
  }
}

TEST_F(PressTable, RefusesAContactWithoutAWidthAndUnitsAndColumnsThatAreUnknown) {
  const path scene = Scene("20 kPa", "");
  const auto refusal = [&](const std::string& header, const std::string& row) {
    return Refusal({.data = {Press(header, row)}, .scene = scene});
  };
  EXPECT_THAT(refusal(header_, row_), HasSubstr("a contact without a width"));
  const std::string wide = ",width", width = ",0.012";
  EXPECT_THAT(refusal("case,x,y,z,dx,dy,dz,fx,fy,fz (g)" + wide, row_ + width),
              HasSubstr("unit g is not understood"));
  EXPECT_THAT(refusal("case,x,y,z,dx,dy,dz,fx,fy,fz (mm)" + wide, row_ + width),
              HasSubstr("a unit of another quantity"));
  EXPECT_THAT(refusal(header_ + ",weight" + wide, row_ + ",1" + width),
              HasSubstr("column = weight: expected case,x"));
  EXPECT_THAT(refusal("case,x,y,z,dx,dy,dz,width", "a,0.02,0.02,0.02,0,0,-0.001,0.012"),
              HasSubstr("no column fx"));
  // Grams in a column without a unit.
  EXPECT_THAT(refusal(header_ + wide, "a,0.02,0.02,0.02,0,0,-0.001,0,0,-28.6" + width),
              HasSubstr("that of the scene is 2e+04 Pa: Check the units"));
  EXPECT_NEAR(Modulus(scene, Press("case,x (mm),y (mm),z (mm),dx,dy,dz (mm),fx,fy,fz (gf),width",
                                   "a,20,20,20,0,0,-1,0,0,-29.16,0.012")) /
                  Modulus(scene, Press(header_ + wide, row_ + width)),
              1, 1e-3);
}

// Reference: Timoshenko's cantilever under its weight q and a load F at its tip, without Poisson's
// effect at the clamp: w = q L^4 / 8 E I + q L^2 / 2 k G A + F L^3 / 3 E I + F L / k G A, k = 5/6.
TEST_F(IdentifyCommand, FindsABeamsModulusFromItsSag) {
  const double E = 50e3, L = 0.2, h = 0.02, density = 1000, g = 9.81, F = 0.002;
  const double A = h * h, I = A * A / 12, G = E / 2, q = density * g * A;
  const double sag = q * std::pow(L, 4) / (8 * E * I) + q * L * L / (2 * 5.0 / 6 * G * A);
  const double more = F * std::pow(L, 3) / (3 * E * I) + F * L / (5.0 / 6 * G * A);
  const path scene = Write("beam.yaml",
                           "name: beam\nobject:\n  geometry: {box: {size: [200 mm, 20 mm, 20 mm], "
                           "cells: [10, 2, 2]}}\n  material: {young_modulus: 5 kPa, poisson_ratio: "
                           "0, density: 1 g/cm3}\n  fixed: {plane: {axis: x, at: 0 m}}\nmodel: "
                           "{kind: fem, element: tet10, law: linear, gravity: [0, 0, -9.81]}\n");
  const std::string header = "case,x,y,z,fx,fy,fz,dx,dy,dz\n";
  const std::string table =
      "case,x,y,z,fx,fy,fz,dx,dy,dz,width\n" +
      Formatted("sag,0.2,0.01,0.01,,,,,,%.6g,\nload,0.2,0.01,0.01,0,0,%g,,,%.6g,0.02\n", -sag, -F,
                -sag - more);
  const json fit =
      Run({.data = {"loads=" + Write("sag.csv", table).string()}, .scene = scene}).at("loads");
  EXPECT_NEAR(fit.at("young_modulus_Pa").get<double>() / E, 1, 0.02);
  for (const auto& one : fit.at("alone_Pa")) EXPECT_NEAR(one.at(1).get<double>() / E, 1, 0.02);
  EXPECT_THAT(
      Refusal({.data = {"loads=" + Write("none.csv", header + "a,0.2,0.01,0.01,,,,,,\n").string()},
               .scene = scene}),
      HasSubstr("expected a row with a dx, dy or dz"));
  EXPECT_THAT(Refusal({.data = {"loads=" +
                                Write("up.csv", header + "a,0.2,0.01,0.01,,,,,,0.01\n").string()},
                       .scene = scene}),
              HasSubstr("point away from gravity"));
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

// A block of 127 kPa is pressed before a camera, and its true force is known. The images then give
// the modulus, whatever the scene states. Tolerance: the errors of model and cameras in the force.
TEST_F(IdentifyCommand, ImagesAndAKnownForceDetermineTheModulus) {
  const path block = SourcePath("/deploy/scenes/silicone-block.yaml");
  const path out = folder_ / "block";
  RunOffline(LoadScene(block, {"operator.press={depth: 4 mm, speed: 40 mm/s}"}),
             {.out = out, .frames = true}, {});
  std::string forces = "sequence,fx,fy,fz\n";
  CsvTable states(out / "states.csv");
  const auto column = [&](const char* name) { return *states.Find(name); };
  while (states.Next()) {
    forces +=
        Formatted("%.0f,%.6f,%.6f,0\n", states.Number(column("sequence"), 1e9),
                  states.Number(column("true_fx"), 1e9), states.Number(column("true_fy"), 1e9));
  }
  IdentifyRequest options;
  options.data = {"images=" + Write("forces.csv", forces).string()};
  options.scene = block;
  options.overrides = {"sense.camera={file: '" + (out / "frames/%06d.png").string() +
                           "', pixel: 0.35 mm, pose: {translation: [44 mm, 54 mm, 0]}}",
                       "object.material.young_modulus=60 kPa"};
  const json fit = Run(options).at("images");
  EXPECT_NEAR(fit.at("young_modulus_Pa").get<double>(), 127e3, 0.015 * 127e3);
  EXPECT_GT(fit.at("sigma_Pa").get<double>(), 0);
  EXPECT_GT(fit.at("pressed").get<int>(), 20);
}

TEST_F(IdentifyCommand, SaysWhatForcesOfImagesMustBe) {
  const auto refusal = [&](const std::string& text, bool recorded = true) {
    IdentifyRequest options;
    options.data = {"images=" + Write("forces.csv", text).string()};
    options.scene = SourcePath("/deploy/scenes/silicone-block.yaml");
    const std::string image = Write("1.png", "not looked at").string();
    if (recorded) options.overrides = {"sense.camera={file: '" + image + "', pixel: 0.35 mm}"};
    return Refusal(options);
  };
  EXPECT_THAT(refusal("a,b\n1,2\n"), HasSubstr("forces.csv:1: no column force"));
  EXPECT_THAT(refusal("sequence,force\n1,2\n1,3\n"), HasSubstr(":3: sequence: expected each"));
  EXPECT_THAT(refusal("sequence,force\n1.5,2\n"), HasSubstr(":2: sequence: expected a whole"));
  EXPECT_THAT(refusal("force\n1\n", false), HasSubstr("expected a scene with recorded"));
  EXPECT_THAT(Refusal({.data = {"images=forces.csv"}}), HasSubstr("needs --scene"));
}

}  // namespace
}  // namespace palpate
