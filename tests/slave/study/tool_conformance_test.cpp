// The same tool on the same body is the same press: in `solve`, and in the study that `check`,
// `study` and `auto` run, for every kind of model.
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slave/scene/scene_loader.h"
#include "slave/study/own_model.h"
#include "tests/reference/solve_fixture.h"

namespace palpate {
namespace {

using Row = std::map<std::string, double>;

// 60 x 60 x 30 mm, E = 30 kPa, nu = 0.3, glued to a table.
std::string Block(const std::string& model, int cells) {
  const std::string n = std::to_string(cells);
  return "name: block\nobject:\n  geometry: {box: {size: [60 mm, 60 mm, 30 mm], cells: [" + n +
         ", " + n + ", " + std::to_string(cells / 2) +
         "]}}\n  material: {young_modulus: 30 kPa, poisson_ratio: 0.3}\n"
         "  fixed: {plane: {axis: z, at: 0 mm}}\noperator: {press: {depth: 2 mm}}\n"
         "study: {contacts: [[30 mm, 30 mm, 30 mm]]}\nmodel: " +
         model + "\n";
}
std::string Sheet(const std::string& model) {
  return "name: sheet\nobject:\n"
         "  geometry: {rectangle: {width: 60 mm, height: 60 mm, thickness: 6 mm}}\n"
         "  material: {young_modulus: 30 kPa, poisson_ratio: 0.3}\n"
         "  fixed: {side: bottom}\noperator: {press: {depth: 2 mm}}\n"
         "study: {contacts: [[30 mm, 60 mm, 0]]}\nmodel: " +
         model + "\n";
}
std::string Plate(const std::string& model, const std::string& depth) {
  return "name: plate\nobject:\n  geometry: {membrane: {radius: 60 mm, thickness: 1 mm}}\n"
         "  material: {young_modulus: 3 MPa, poisson_ratio: 0.3}\n"
         "  fixed: {side: rim}\noperator: {press: {depth: " +
         depth + "}}\nstudy: {contacts: [[0, 0, 0]]}\nmodel: " + model + "\n";
}

constexpr const char* kVolumePress = "case,x,y,z,dx,dy,dz\n1,0.03,0.03,0.03,0,0,-0.002\n";
constexpr const char* kSheetPress = "case,x,y,dx,dy\n1,0.03,0.06,0,-0.002\n";
constexpr const char* kPlatePress = "case,x,y,z,dx,dy,dz\n1,0,0,0,0,0,-0.0004\n";

class ToolConformance : public SolveFiles {
 protected:
  double Solved(const std::string& scene, const std::string& tool, const std::string& contacts) {
    const std::vector<Row> rows = Solve(scene + "tool: " + tool + "\n", contacts, "");
    if (rows.size() != 1) return std::nan("");
    double work = 0, way = 0;  // the force along the path
    for (const char axis : {'x', 'y', 'z'}) {
      const double moved = rows[0].at(std::string("d") + axis);
      work += rows[0].at(std::string("f") + axis) * moved;
      way = std::hypot(way, moved);
    }
    return work / way;
  }
  double Studied(const std::string& scene, const std::string& tool) {
    const auto file = Write("studied.yaml", scene + "tool: " + tool + "\n");
    Scene loaded = LoadScene(file, {}, SceneUse::kSolve);
    const auto own = study::StudyOwn(std::move(loaded), study::DefaultModelFactory());
    EXPECT_EQ(own.row.outcome, study::Outcome::kAnswered) << own.row.reason;
    return own.row.answers.empty() ? std::nan("") : own.row.answers.front().full.value;
  }
};

// Reference: the commands must agree. Tolerance: the residual of the iterations.
TEST_F(ToolConformance, AllCommandsGiveTheSamePress) {
  struct Case {
    std::string scene, press;
    double tolerance;
  };
  const std::vector<Case> cases{
      {Sheet("{kind: bem2d, elements: 120}"), kSheetPress, 1e-9},
      {Sheet("{kind: bem2d, elements: 120, contact: frictionless}"), kSheetPress, 1e-9},
      {Plate("{kind: plate}", "0.4 mm"), kPlatePress, 1e-9},
      {Plate("{kind: plate-large}", "0.4 mm"), kPlatePress, 1e-6},
      {Block("{kind: fem-green}", 8), kVolumePress, 1e-9},
      {Block("{kind: fem-green, contact: frictionless}", 8), kVolumePress, 1e-9},
      {Block("{kind: fem-green, element: tet10}", 4), kVolumePress, 1e-9},
      {Block("{kind: fem, law: linear}", 8), kVolumePress, 1e-4},
      {Block("{kind: fem}", 8), kVolumePress, 1e-3},
      {Block("{kind: fem, contact: frictionless}", 8), kVolumePress, 1e-3}};
  for (const Case& one : cases) {
    for (const char* tool : {"{width: 12 mm}", "{shape: round, radius: 20 mm}"}) {
      const double solved = Solved(one.scene, tool, one.press);
      ASSERT_GT(solved, 0) << one.scene << tool;
      EXPECT_NEAR(Studied(one.scene, tool) / solved, 1, one.tolerance) << one.scene << tool;
    }
  }
}

// Reference: hexahedra of another program with complementarity in the contact, refined at the
// contact, without friction: 0.6642 and 0.6631 N on two meshes. Hertz's half-space gives 0.556 N.
// Tolerance of 10 %: three to five elements lie under the tool.
TEST_F(ToolConformance, ARoundToolIsRoundInEveryKindOfVolume) {
  const char* tool = "{shape: round, radius: 20 mm}";
  EXPECT_NEAR(Solved(Block("{kind: fem-green, contact: frictionless}", 18), tool, kVolumePress),
              0.664, 0.1 * 0.664);
  const double bonded = Solved(Block("{kind: fem-green}", 18), tool, kVolumePress);
  EXPECT_NEAR(Solved(Block("{kind: fem, law: linear}", 18), tool, kVolumePress), bonded,
              1e-3 * bonded);
  EXPECT_NEAR(Solved(Block("{kind: fem}", 18), tool, kVolumePress), bonded, 0.1 * bonded);
}

// Reference: as above, and 0.686 N where the block sticks to the tool. Tolerance of 10 %: contact
// radius 6 mm, edges of 6 and 7.5 mm.
TEST_F(ToolConformance, QuadraticFacesCarryARoundTool) {
  const char* tool = "{shape: round, radius: 20 mm}";
  for (const int cells : {8, 10}) {
    for (const auto& [law, force] :
         {std::pair{"frictionless", 0.6634}, std::pair{"bonded", 0.686}}) {
      const std::string model =
          std::string("{kind: fem-green, element: tet10, contact: ") + law + "}";
      EXPECT_NEAR(Solved(Block(model, cells), tool, kVolumePress) / force, 1, 0.1) << law << cells;
    }
    const std::string model = "{kind: fem, element: tet10, law: linear}";
    EXPECT_NEAR(Solved(Block(model, cells), tool, kVolumePress) / 0.686, 1, 0.1) << cells;
  }
}

// Reference: the clamped plate under a point load at its centre, w = F a^2 / (16 pi D) (Timoshenko
// and Woinowsky-Krieger, eq. 92). The tool's radius does not enter: it touches in a point.
TEST_F(ToolConformance, ARoundToolTouchesAPlateInAPoint) {
  const double E = 3e6, nu = 0.3, t = 1e-3, a = 0.06, w = 4e-4;
  const double D = E * t * t * t / (12 * (1 - nu * nu));
  const double force = 16 * std::numbers::pi * D * w / (a * a);
  for (const char* tool : {"{shape: round, radius: 3 mm}", "{shape: round, radius: 6 mm}"}) {
    EXPECT_NEAR(Solved(Plate("{kind: plate}", "0.4 mm"), tool, kPlatePress) / force, 1, 1e-6);
  }
}

}  // namespace
}  // namespace palpate
