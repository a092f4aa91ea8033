#include "slave/mechanics/factory/make_model.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "slave/mechanics/bem/bem2d_model.h"
#include "slave/mechanics/plate/plate_surface.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Scene BlockScene() {
  Scene scene;
  scene.object.geometry = RectangleGeometry{0.088, 0.044, 0.009};
  scene.object.material = {.young_modulus = 127e3, .poisson_ratio = 0.49};
  scene.object.fixed = {{FixedSide{"bottom"}}};
  scene.model.elements = 60;
  return scene;
}

int HeldCount(const Scene& scene, int component) {
  const auto model = MakeModel(scene, MeshOutline(scene, std::nullopt));
  const auto& greens = dynamic_cast<const Bem2dModel&>(*model).greens_functions();
  int count = 0;
  for (int i = 0; i < greens.size(); ++i) count += greens.held(i, component) ? 1 : 0;
  return count;
}

std::string RefusalOfScene(const Scene& scene) {
  return Thrown<std::invalid_argument>([&] { MakeModel(scene, MeshOutline(scene, std::nullopt)); });
}

// The vertices along the bottom of a rectangle with 60 elements, whose longer side is twice the
// other.
TEST(HeldVertices, AreThoseOfFixedElementsPlanesAndRims) {
  const Scene block = BlockScene();
  const BoundaryMesh outline = MeshOutline(block, std::nullopt);
  const auto held = HeldVertices(block, outline);
  EXPECT_EQ(held.size(), 21U);
  for (const std::uint32_t vertex : held) {
    EXPECT_NEAR(outline.elements[vertex].a.y(), outline.elements[held[0]].a.y(), 1e-12);
  }
  Scene cube = block;
  cube.object.geometry = BoxGeometry{{0.03, 0.03, 0.03}, {2, 2, 2}};
  cube.object.fixed = {Fixed{FixedPlane{2, 0}, {false, false, true}}};
  const SurfaceMesh skin = SurfaceOf(std::get<SolidMesh>(MeshObject(cube, std::nullopt)));
  EXPECT_EQ(HeldVertices(cube, skin).size(), 9U);
  Scene membrane = block;
  membrane.object.geometry = MembraneGeometry{0.039, 0.001};
  const SurfaceMesh disc = MembraneGrid(0.039);
  const auto rim = HeldVertices(membrane, disc);
  EXPECT_GT(rim.size(), 10U);
  for (const std::uint32_t node : rim) EXPECT_NEAR(disc.nodes[node].norm(), 0.039, 1e-12);
}

TEST(MakeModel, HoldsSidesArcsPlanesAndElements) {
  Scene scene = BlockScene();  // 20 + 10 + 20 + 10 elements
  EXPECT_EQ(HeldCount(scene, 0), 20);
  scene.object.fixed = {{FixedSide{"left"}}, {FixedSide{"top"}}};
  EXPECT_EQ(HeldCount(scene, 0), 30);
  scene.object.fixed = {{FixedSide{"right"}, {false, true, true}}};
  EXPECT_EQ(HeldCount(scene, 0), 0);
  EXPECT_EQ(HeldCount(scene, 1), 10);
  scene.object.fixed = {{FixedPlane{0, 0.088}}};
  EXPECT_EQ(HeldCount(scene, 0), 10);
  scene.object.geometry = DiscGeometry{0.6e-3, 1.2e-3};
  // Midpoints at multiples of 6 degrees, the ends at 150 and 210 included.
  scene.object.fixed = {{FixedArc{180 * kDegree, 30 * kDegree}}};
  EXPECT_EQ(HeldCount(scene, 0), 11);
  scene.object.fixed = {{FixedNodes{{0, 5, 59}}}};
  EXPECT_EQ(HeldCount(scene, 0), 3);
}

TEST(MakeModel, RefusesWhatHoldsNothing) {
  Scene scene = BlockScene();
  scene.object.fixed = {{FixedPlane{1, 0.0198}}, {FixedSide{"top"}}};
  EXPECT_EQ(RefusalOfScene(scene), "") << "two elements lie at that height";
  scene.object.fixed = {{FixedPlane{1, 0.0200}}};
  EXPECT_THAT(RefusalOfScene(scene), testing::HasSubstr("plane"));
  scene.object.fixed = {{FixedNodes{{60}}}};
  EXPECT_THAT(RefusalOfScene(scene), testing::HasSubstr("expected 0 to 59"));
}

TEST(MakeModel, NeedsAnOutlineForAnImageContour) {
  Scene scene = BlockScene();
  scene.object.geometry = ImageContourGeometry{0.001};
  EXPECT_THROW(MeshOutline(scene, std::nullopt), std::invalid_argument);
  Outline seen;
  for (int i = 0; i < 40; ++i) {
    seen.outer.emplace_back(std::cos(i * 9 * kDegree), std::sin(i * 9 * kDegree));
  }
  EXPECT_EQ(MeshOutline(scene, seen).size(), 60);
}

}  // namespace
}  // namespace palpate
