// Scenes of volumes and membranes: accepted keys with their defaults, and refused ones.
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/scene/model_kinds.h"
#include "slave/scene/scene_loader.h"
#include "tests/slave/scene/scene_file.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

std::string SolidScene(const std::string& geometry, const std::string& fixed,
                       const std::string& model) {
  return "name: solid\n"
         "object:\n"
         "  geometry: " +
         geometry +
         "\n"
         "  material: {young_modulus: 3.8 kPa, poisson_ratio: 0.15, density: 45 kg/m3}\n" +
         (fixed.empty() ? "" : "  fixed: " + fixed + "\n") + "model: " + model + "\n";
}

constexpr const char* kSolidBox = "{box: {size: [60 mm, 60 mm, 60 mm], cells: [3, 3, 3]}}";
constexpr const char* kBottom = "{plane: {axis: z, at: 0 m}}";

Scene LoadSolid(const std::string& text, SceneUse use = SceneUse::kSolve) {
  const Scratch folder;
  return LoadScene(folder.Write("scene.yaml", text), {}, use);
}

std::string SolidMistakes(const std::string& text, SceneUse use = SceneUse::kSolve) {
  return Thrown<SceneError>([&] { LoadSolid(text, use); });
}

TEST(SolidSceneTest, FemReadsWhatTheContractNames) {
  const Scene scene = LoadSolid(SolidScene(
      kSolidBox, kBottom,
      "{kind: fem, element: tet10, law: linear, time: dynamic, step: 5 ms, residual: 1e-9, "
      "gravity: [0, 0, -9.80665]}"));
  const FemOptions& fem = scene.model.fem;
  EXPECT_EQ(fem.element, FemOptions::Element::kTet10);
  EXPECT_EQ(fem.law, FemOptions::Law::kLinear);
  EXPECT_EQ(fem.time, FemOptions::Time::kDynamic);
  EXPECT_EQ(fem.step, 0.005);
  EXPECT_EQ(fem.residual, 1e-9);
  EXPECT_EQ(fem.gravity_O, Eigen::Vector3d(0, 0, -9.80665));
  EXPECT_EQ(scene.object.fixed.size(), 1U);
}

TEST(SolidSceneTest, ASceneThatNamesNoLawGetsOneForLargeStrainsAtRest) {
  using Law = FemOptions::Law;
  const auto law = [](const std::string& model) {
    return LoadSolid(SolidScene(kSolidBox, kBottom, model)).model.fem.law;
  };
  EXPECT_EQ(law("{kind: fem}"), Law::kNeoHookean);
  EXPECT_EQ(law("{kind: fem, time: dynamic}"), Law::kCorotational);
  EXPECT_EQ(law("{kind: fem, law: corotational}"), Law::kCorotational);
}

// Reference: the row of deploy/scenes/materials.md.
TEST(SolidSceneTest, ANamedMaterialGivesWhatItsRowStates) {
  const auto scene_with = [](const std::string& material) {
    std::string text = SolidScene(kSolidBox, kBottom, "{kind: fem}");
    const std::string usual = "{young_modulus: 3.8 kPa, poisson_ratio: 0.15, density: 45 kg/m3}";
    return text.replace(text.find(usual), usual.size(), material);
  };
  const Material named = LoadSolid(scene_with("{name: dragon-skin-10}")).object.material;
  EXPECT_DOUBLE_EQ(named.young_modulus, 263.8e3);
  EXPECT_DOUBLE_EQ(named.poisson_ratio, 0.499);
  EXPECT_DOUBLE_EQ(named.density, 1070);
  EXPECT_DOUBLE_EQ(named.young_modulus_tolerance, 0.2);
  const Material own =
      LoadSolid(scene_with("{name: dragon-skin-10, young_modulus: 240 kPa}")).object.material;
  EXPECT_DOUBLE_EQ(own.young_modulus, 240e3);
  EXPECT_DOUBLE_EQ(own.poisson_ratio, 0.499);
  EXPECT_EQ(own.young_modulus_tolerance, 0) << "that of the table is of its own modulus";
  EXPECT_THAT(SolidMistakes(scene_with("{name: ecoflex-00-30}")), HasSubstr("poisson_ratio"));
  EXPECT_THAT(SolidMistakes(scene_with("{name: gelatine}")),
              HasSubstr("expected dragon-skin-10, "));
}

TEST(SolidSceneTest, OptionsWithoutEffectAreRefused) {
  for (const auto& [model, mistake] :
       {std::pair{"{kind: fem-green, contact: friction}", "expected bonded or frictionless"},
        std::pair{"{kind: fem, element: tet10, contact: friction}", "needs tet4, statics"},
        std::pair{"{kind: fem, time: dynamic, contact: frictionless}", "needs tet4, statics"},
        std::pair{"{kind: fem, law: ogden, terms: [[1, 2]], contact: friction}",
                  "needs tet4, statics"},
        std::pair{"{kind: auto, contact: friction}", "expected bonded or frictionless"},
        std::pair{"{kind: fem-green, friction: 0.5}", "nothing here: use fem with"},
        std::pair{"{kind: fem, time: dynamic, deadline: 5 ms}", "nothing here: use fem with"},
        std::pair{"{kind: fem-green, deadline: 5 ms}", "nothing here: use fem with"},
        std::pair{"{kind: fem, friction: 0.5}", "nothing without `contact: friction`"},
        std::pair{"{kind: fem, contact: friction}", "model.friction"},
        std::pair{"{kind: fem, contact: friction, friction: -1}", "> 0"},
        std::pair{"{kind: fem, deadline: 0 us}", "> 0"}}) {
    const std::string text = SolidMistakes(SolidScene(kSolidBox, kBottom, model));
    EXPECT_THAT(text, HasSubstr(mistake)) << model;
    EXPECT_THAT(text, HasSubstr("scene.yaml:6: ")) << model;
  }
}

std::string CapsuleScene(const std::string& kind, const std::string& tool) {
  return SolidScene(kSolidBox, kBottom, "{kind: " + kind + "}") + "tool: " + tool + "\n";
}

TEST(SolidSceneTest, OnlyFemTakesACapsuleOrARectangle) {
  const Tool tool =
      *LoadSolid(
           CapsuleScene("fem", "{shape: capsule, radius: 4 mm, length: 12 mm, axis: [0, 2, 0]}"))
           .tool;
  EXPECT_EQ(tool.shape, Tool::Shape::kCapsule);
  EXPECT_EQ(tool.radius, 0.004);
  EXPECT_EQ(tool.width, 0.008);
  EXPECT_EQ(tool.length, 0.012);
  EXPECT_TRUE(tool.axis_O.isApprox(Eigen::Vector3d::UnitY()));
  constexpr const char* kCapsule = "{shape: capsule, radius: 4 mm, length: 12 mm}";
  for (const char* kind : {"fem, element: tet10", "fem-green", "auto"}) {
    EXPECT_THAT(SolidMistakes(CapsuleScene(kind, kCapsule)), HasSubstr("others need fem with"))
        << kind;
  }
  const Tool plate =
      *LoadSolid(CapsuleScene("fem", "{shape: rectangle, width: 4 mm, length: 12 mm}")).tool;
  EXPECT_EQ(plate.shape, Tool::Shape::kRectangle);
  EXPECT_EQ(plate.width, 0.004);
  EXPECT_EQ(plate.length, 0.012);
  for (const auto& [shape, mistake] :
       {std::pair{"{shape: capsule, radius: 4 mm}", "tool.length"},
        std::pair{"{shape: capsule, length: 4 mm}", "tool.width"},
        std::pair{"{shape: capsule, radius: 4 mm, length: 0 mm}", "> 0"},
        std::pair{"{shape: capsule, radius: 4 mm, length: 1 mm, axis: [0, 0, 0]}", "tool.axis"},
        std::pair{"{shape: round, radius: 4 mm, length: 12 mm}", "without `shape: capsule`"},
        std::pair{"{shape: rectangle, width: 4 mm}", "tool.length"},
        std::pair{"{shape: rectangle, width: 4 mm, length: 4 mm, radius: 4 mm}",
                  "nothing with a flat"},
        std::pair{"{shape: flat, width: 4 mm, axis: [0, 0, 1]}", "without `shape: capsule`"}}) {
    EXPECT_THAT(SolidMistakes(CapsuleScene("fem", shape)), HasSubstr(mistake)) << shape;
  }
}

TEST(SolidSceneTest, ADomeThatIsNoneIsRefused) {
  for (const auto& [membrane, accepted] :
       {std::pair{"semi_axes: [70 mm, 50 mm, 71 mm], inflation: 110 mm", "at most 1.5 times"},
        std::pair{"semi_axes: [70 mm, 50 mm, 71 mm], inflation: 1 mm", "at least a twentieth"},
        std::pair{"semi_axes: [70 mm, 5 mm, 71 mm], inflation: 40 mm", "at most 10 to 1"},
        std::pair{"semi_axes: [70 mm, 50 mm], inflation: 40 mm", "semi_axes"},
        std::pair{"semi_axes: [70 mm, 50 mm, 71 mm]", "inflation"},
        std::pair{"inflation: 40 mm", "semi_axes"},
        std::pair{"semi_axes: [70 mm, 50 mm, 71 mm], inflation: 40 mm, air: 3 mm", "a volume"}}) {
    const std::string geometry = std::string("{membrane: {thickness: 1 mm, ") + membrane + "}}";
    EXPECT_THAT(SolidMistakes(SolidScene(geometry, "", "{kind: membrane}")), HasSubstr(accepted))
        << membrane;
  }
}

TEST(SolidSceneTest, AUnitOfAMeshFileNeedsNoNumber) {
  const Scratch folder;
  folder.Write("cube.stl", "solid cube\nendsolid cube\n");
  for (const auto& [unit, metres] :
       {std::pair{"mm", 1e-3}, std::pair{"1 mm", 1e-3}, std::pair{"25.4 mm", 25.4e-3}}) {
    const std::string geometry = std::string("{mesh: cube.stl, unit: ") + unit + "}";
    const Scene scene =
        LoadScene(folder.Write("scene.yaml", SolidScene(geometry, kBottom, "{kind: fem-green}")),
                  {}, SceneUse::kSolve);
    EXPECT_DOUBLE_EQ(std::get<MeshFileGeometry>(scene.object.geometry).unit, metres);
  }
  const std::string dozen = "{mesh: cube.stl, unit: dozen}";
  EXPECT_THAT(Thrown<SceneError>([&] {
                LoadScene(
                    folder.Write("scene.yaml", SolidScene(dozen, kBottom, "{kind: fem-green}")), {},
                    SceneUse::kSolve);
              }),
              HasSubstr("unit = dozen: expected a unit such as mm"));
}

struct RefusedSolid {
  const char* name;
  const char *geometry, *fixed, *model;
  const char* message;
};

class SolidRefusalTest : public ::testing::TestWithParam<RefusedSolid> {};

TEST_P(SolidRefusalTest, SaysWhatIsAccepted) {
  const RefusedSolid& bad = GetParam();
  EXPECT_THAT(SolidMistakes(SolidScene(bad.geometry, bad.fixed, bad.model)),
              HasSubstr(bad.message));
}

const RefusedSolid kRefusals[] = {
    {"CellsNotWhole", "{box: {size: [1, 1, 1], cells: [1.5, 1, 1]}}", kBottom, "{kind: fem}",
     "cells = [1.5, 1, 1]: expected three whole numbers"},
    {"TooManyCells", "{box: {size: [1, 1, 1], cells: [100, 100, 100]}}", kBottom, "{kind: fem}",
     "4 million tetrahedra"},
    {"NoSuchMesh", "{mesh: absent.node}", kBottom, "{kind: fem}",
     "mesh = absent.node: expected a file that can be read"},
    {"PlateOfABox", kSolidBox, kBottom, "{kind: plate}",
     "model.kind = plate: expected auto, fem or fem-green"},
    {"MembraneHeldElsewhere", "{membrane: {radius: 39 mm, thickness: 1 mm}}", "{nodes: [1]}",
     "{kind: plate}", "expected {side: rim}"},
    {"SideOfABox", kSolidBox, "{side: bottom}", "{kind: fem}",
     "object.fixed.side = bottom: expected no side, because this is a volume"},
    {"OgdenWithoutTerms", kSolidBox, kBottom, "{kind: fem, law: ogden}", "model.terms"},
    {"OgdenShares", kSolidBox, kBottom, "{kind: fem, law: ogden, terms: [[0.5, 2]]}",
     "one to six terms whose shares add up to 1"},
    {"OgdenUnstable", kSolidBox, kBottom, "{kind: fem, law: ogden, terms: [[1.5, 2], [-0.5, -2]]}",
     "a share (0 to 1)"},
    {"FrictionlessTet10", kSolidBox, kBottom, "{kind: fem, element: tet10, contact: frictionless}",
     "model.contact = frictionless: expected bonded: `fem` needs tet4"},
};

INSTANTIATE_TEST_SUITE_P(Scenes, SolidRefusalTest, ::testing::ValuesIn(kRefusals),
                         [](const auto& row) { return std::string(row.param.name); });

// A box with regions, of which `regions` is the value in the scene's fifth line.
std::string WithRegions(const std::string& regions, const std::string& model = "{kind: fem}") {
  std::string text = SolidScene(kSolidBox, kBottom, model);
  return text.insert(text.find("  fixed:"), "  regions: " + regions + "\n");
}

TEST(SolidSceneTest, RegionsAreSpheresBoxesAndLayersInTheirOrder) {
  const Scene scene = LoadSolid(
      WithRegions("[{sphere: {centre: [30 mm, 30 mm, 40 mm], radius: 5 mm}, young_modulus: 19 kPa},"
                  " {box: {from: [0, 0, 0], to: [10 mm, 20 mm, 30 mm]}, young_modulus: 1 kPa},"
                  " {layer: {axis: z, from: 50 mm, to: 60 mm}, young_modulus: 38 kPa}]"));
  ASSERT_EQ(scene.object.regions.size(), 3U);
  EXPECT_EQ(scene.object.regions[0].line, 5);
  EXPECT_DOUBLE_EQ(RelativeModulus(scene.object, {0.03, 0.034, 0.04}), 5);
  EXPECT_DOUBLE_EQ(RelativeModulus(scene.object, {0.03, 0.036, 0.04}), 1);
  EXPECT_DOUBLE_EQ(RelativeModulus(scene.object, {0.005, 0.015, 0.025}), 1 / 3.8);
  EXPECT_DOUBLE_EQ(RelativeModulus(scene.object, {0.005, 0.025, 0.025}), 1);
  EXPECT_DOUBLE_EQ(RelativeModulus(scene.object, {-1, 7, 0.055}), 10);
}

TEST(SolidSceneTest, RegionsAreRefusedWithWhatIsAccepted) {
  EXPECT_THAT(SolidMistakes(WithRegions("[{young_modulus: 1 kPa}]")),
              HasSubstr(":5: object.regions.0"));
  EXPECT_THAT(
      SolidMistakes(WithRegions("[{layer: {axis: z, from: 2 mm, to: 1 mm}, young_modulus: 1 "
                                "kPa}]")),
      HasSubstr("more than `from`"));
  EXPECT_THAT(SolidMistakes(WithRegions("[{box: {from: [0, 0, 0], to: [1 mm, 0, 1 mm]}, "
                                        "young_modulus: 1 kPa}]")),
              HasSubstr("more than `from`"));
  EXPECT_THAT(SolidMistakes(WithRegions("[{layer: {axis: z, from: 1 mm, to: 2 mm}}]")),
              HasSubstr("young_modulus"));
  EXPECT_THAT(SolidMistakes(WithRegions("[]")), HasSubstr("object.regions"));
  const std::string layer = "[{layer: {axis: z, from: 0 mm, to: 40 mm}, young_modulus: 1 kPa}]";
  std::string plate = SolidScene("{membrane: {radius: 9 mm, thickness: 0.1 mm}}", "", "{}");
  plate.insert(plate.find("model:"), "  regions: " + layer + "\n");
  EXPECT_THAT(SolidMistakes(plate), HasSubstr("only a box or a mesh has regions"));
}

// The scene with a series in its material.
std::string WithRelaxation(const std::string& terms, const std::string& model) {
  std::string text = SolidScene(kSolidBox, kBottom, model);
  return text.insert(text.find(", density"), ", relaxation: " + terms);
}

TEST(SolidSceneTest, RelaxationIsASeriesWithAStep) {
  const Scene scene = LoadSolid(WithRelaxation(
      "[{share: 0.3, time: 0.5 s}, {share: 20 %, time: 5 s}]", "{kind: fem-green, step: 10 ms}"));
  const auto& terms = scene.object.material.relaxation;
  ASSERT_EQ(terms.size(), 2U);
  EXPECT_EQ(terms[0].share, 0.3);
  EXPECT_EQ(terms[0].time, 0.5);
  EXPECT_EQ(terms[1].share, 0.2);
  EXPECT_EQ(scene.model.fem.step, 0.01);
  EXPECT_DOUBLE_EQ(Relaxed(scene.object).material.young_modulus, 0.5 * 3800);
}

TEST(SolidSceneTest, RelaxationIsRefusedWithWhatIsAccepted) {
  const std::string green = "{kind: fem-green}";
  EXPECT_THAT(
      SolidMistakes(WithRelaxation("[{share: 0.6, time: 1 s}, {share: 0.4, time: 2 s}]", green)),
      HasSubstr("add up to less than 1"));
  EXPECT_THAT(SolidMistakes(WithRelaxation("[]", green)), HasSubstr("one to 8 terms"));
  EXPECT_THAT(SolidMistakes(WithRelaxation("[{share: 0, time: 1 s}]", green)), HasSubstr("share"));
  EXPECT_THAT(SolidMistakes(WithRelaxation("[{share: 0.1, time: 0 s}]", green)), HasSubstr("time"));
  EXPECT_THAT(SolidMistakes(WithRelaxation("[{share: 0.1}]", green)), HasSubstr("time"));
  for (const char* kind : {"{kind: fem}", "{}"}) {
    EXPECT_THAT(SolidMistakes(WithRelaxation("[{share: 0.1, time: 1 s}]", kind)),
                HasSubstr("use fem-green"))
        << kind;
  }
}

}  // namespace
}  // namespace palpate
