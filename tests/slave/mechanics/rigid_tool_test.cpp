// Compares the plate models under a rigid flat tool with solid sheets: a neo-Hookean body whose
// surface nodes are pushed out of the tool one by one (slave/reference/membrane). It shares no code
// with the plates.
#include <cmath>
#include <optional>

#include <gtest/gtest.h>

#include "slave/mechanics/factory/make_model.h"
#include "slave/mechanics/factory/tool_press.h"
#include "slave/reference/membrane/pressed_membrane.h"

namespace palpate {
namespace {

struct Drawn {
  double slenderness = 0, width = 0;  // t / a, relative to the diameter
  double place = 0, depth = 0;        // relative to the radius, relative to the thickness
};

// Halton's sequence: number `index` in `base`, in (0, 1).
double Halton(int index, int base) {
  double share = 1, value = 0;
  for (; index > 0; index /= base) value += (share /= base) * (index % base);
  return value;
}

// The tool stays within 0.9 of the radius.
Drawn Draw(int index) {
  Drawn drawn;
  drawn.slenderness = 1 / (40 + 40 * Halton(index, 2));
  drawn.width = 0.02 + 0.28 * Halton(index, 3);
  drawn.place = std::min(0.7, 0.9 - drawn.width) * Halton(index, 5);
  drawn.depth = 0.3 + 3.7 * Halton(index, 7);
  return drawn;
}

Scene DrawnScene(const Drawn& drawn, const char* kind) {
  Scene scene;
  scene.object.geometry = MembraneGeometry{.radius = 0.04, .thickness = 0.04 * drawn.slenderness};
  scene.object.material = {.young_modulus = 1e6, .poisson_ratio = 0.45};
  scene.model.kind = kind;
  scene.tool = Tool{.width = 0.08 * drawn.width};
  return scene;
}

ContactResponse AnswerAt(const Scene& scene, const Drawn& drawn, double depth) {
  const ObjectMesh mesh = MeshObject(scene, std::nullopt);
  const auto model = MakeModel(scene, mesh);
  Solution solution;
  return ToolPress(scene, *scene.tool, mesh)
      .Press({.p_O = {0.04 * drawn.place, 0, 0},
              .width = scene.tool->width,
              .prescribed_O = {0, 0, -depth}},
             model.get(), &solution);
}

// Reference: the solid, accurate to 0.5 % on this mesh. The accepted error is model.tolerance;
// answers with a larger error must be flagged.
TEST(RigidTool, ThirtyPressesAreWithinFivePerCentOfASolidOrFlagged) {
  int valid = 0, small_valid = 0;
  for (int index = 1; index <= 30; ++index) {
    const Drawn drawn = Draw(index);
    const Scene scene = DrawnScene(drawn, "plate-large");
    const auto& sheet = std::get<MembraneGeometry>(scene.object.geometry);
    simulation::PressedMembrane truth(sheet, scene.object.material, scene.tool->width,
                                      {0.04 * drawn.place, 0}, {7, 1}, 0,
                                      simulation::ToolFace::kRigid);
    const double small = 0.3 * sheet.thickness, depth = drawn.depth * sheet.thickness;
    const auto compare = [&](const Scene& pressed, double at, int* count) {
      const auto response = AnswerAt(pressed, drawn, at);
      const double error = response.force_O.z() / truth.press().depth_steps.back()->force - 1;
      const bool is_valid = response.validity == Validity::kValid;
      if (is_valid) {
        EXPECT_LT(std::abs(error), 0.05)
            << "t " << drawn.slenderness << " width " << drawn.width << " place " << drawn.place
            << " depth " << at / sheet.thickness << ' ' << pressed.model.kind;
      }
      *count += is_valid ? 1 : 0;
      RecordProperty(std::to_string(index) + pressed.model.kind, std::to_string(error));
    };
    ASSERT_TRUE(truth.Deepen(small));
    compare(DrawnScene(drawn, "plate"), small, &small_valid);
    for (double depth_step = 2 * small; depth_step < depth; depth_step *= 2)
      ASSERT_TRUE(truth.Deepen(depth_step)) << depth_step;
    ASSERT_TRUE(truth.Deepen(depth));
    compare(scene, depth, &valid);
  }
  EXPECT_GE(valid, 20);
  EXPECT_GE(small_valid, 8);
}

}  // namespace
}  // namespace palpate
