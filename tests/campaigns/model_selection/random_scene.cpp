#include "tests/campaigns/model_selection/random_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/files/mesh_file.h"
#include "tests/support/dice.h"

namespace palpate::model_selection {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Scene Start(Dice* dice, double size, double width) {
  Scene scene;
  scene.object.material = {dice->Decades(3e3, 3e6), dice->Between(0.05, 0.48), 0, 0};
  scene.tool = Tool{.width = width, .depth = std::numeric_limits<double>::infinity()};
  scene.operator_options.press_depth = size * dice->Decades(0.005, 0.05);
  scene.model.kind = "auto";
  scene.model.range = 0.1;
  scene.model.tolerance = dice->Decades(0.005, 0.2);
  scene.model.rate = dice->Decades(60, 5000);
  return scene;
}

Scene StartPlanar(Dice* dice, double size) {
  Scene scene = Start(dice, size, size * dice->Decades(0.03, 0.2));
  scene.model.plane = dice->Chance(0.5) ? Plane::kStress : Plane::kStrain;
  scene.model.contact = dice->Chance(0.25) ? ContactLaw::kFrictionless : ContactLaw::kBonded;
  return scene;
}

Scene Rectangle(Dice* dice) {
  const double size = dice->Decades(0.002, 0.2);
  Scene scene = StartPlanar(dice, size);
  scene.name = "rectangle";
  const double height = size * dice->Between(0.35, 1);
  scene.object.geometry = RectangleGeometry{size, height, size * dice->Between(0.05, 0.3)};
  scene.object.fixed = {{FixedSide{"bottom"}, {true, true, true}}};
  scene.manipulator.home = {size * dice->Between(0.3, 0.7), height + 0.1 * size, 0};
  return scene;
}

Scene Disc(Dice* dice) {
  const double radius = dice->Decades(0.0005, 0.1);
  Scene scene = StartPlanar(dice, 2 * radius);
  scene.name = "disc";
  scene.object.geometry = DiscGeometry{radius, radius * dice->Between(0.1, 1)};
  scene.object.fixed = {{FixedArc{std::numbers::pi, dice->Between(0.3, 1.2)}, {true, true, true}}};
  scene.manipulator.home = {1.2 * radius, 0, 0};
  return scene;
}

// Corners on a bent circle above a flat bottom; often with a hole.
Scene Polygon(Dice* dice) {
  const double size = dice->Decades(0.005, 0.2);
  Scene scene = StartPlanar(dice, size);
  scene.name = "polygon";
  PolygonGeometry polygon;
  polygon.thickness = 0.1 * size;
  polygon.outline.outer = {{-0.35 * size, 0}, {0.35 * size, 0}};
  const int corners = dice->Whole(3, 5);
  for (int i = 0; i < corners; ++i) {
    const double angle = std::numbers::pi * (i + dice->Between(0.3, 0.7)) / corners;
    const double reach = size * dice->Between(0.45, 0.55);
    polygon.outline.outer.emplace_back(reach * std::cos(angle),
                                       0.15 * size + reach * std::sin(angle));
  }
  if (dice->Chance(0.5)) {
    std::vector<Vector2d> hole;
    const double radius = size * dice->Between(0.05, 0.12);
    for (int i = 0; i < 24; ++i) {
      const double angle = 2 * std::numbers::pi * i / 24;
      hole.emplace_back(radius * std::cos(angle), 0.25 * size + radius * std::sin(angle));
    }
    polygon.outline.holes.push_back(std::move(hole));
  }
  scene.object.geometry = std::move(polygon);
  scene.object.fixed = {{FixedSide{"bottom"}, {true, true, true}}};
  scene.manipulator.home = {0, size, 0};
  return scene;
}

Scene StartVolume(Dice* dice, double size) {
  Scene scene = Start(dice, size, size * dice->Decades(0.15, 0.4));
  scene.object.fixed = {{FixedPlane{2, 0}, {true, true, true}}};
  scene.model.tolerance = dice->Decades(0.02, 0.5);
  return scene;
}

Scene Box(Dice* dice) {
  const double size = dice->Decades(0.01, 0.2);
  Scene scene = StartVolume(dice, size);
  scene.name = "box";
  BoxGeometry box{{size, size * dice->Between(0.6, 1), size * dice->Between(0.4, 1)}, {}};
  const int cells = dice->Whole(4, 8);
  for (int k = 0; k < 3; ++k) {
    box.cells[static_cast<std::size_t>(k)] =
        std::max(2, static_cast<int>(std::lround(cells * box.size[k] / size)));
  }
  scene.object.geometry = box;
  return scene;
}

// A half ball on its flat side: the upper half of a cube mesh, projected outwards.
Scene Dome(Dice* dice, const std::filesystem::path& file) {
  const double radius = dice->Decades(0.005, 0.1);
  Scene scene = StartVolume(dice, radius);
  scene.name = "dome";
  const int cells = dice->Whole(3, 4);
  SolidMesh mesh = MeshBox({2, 2, 1}, {2 * cells, 2 * cells, cells});
  for (Vector3d& p : mesh.nodes) {
    const Vector3d q = p - Vector3d(1, 1, 0);
    const Vector3d s = q.cwiseProduct(q);
    // Maps a cube to the ball without flat cells.
    for (int k = 0; k < 3; ++k) {
      const double a = s[(k + 1) % 3], b = s[(k + 2) % 3];
      p[k] = radius * q[k] * std::sqrt(1 - a / 2 - b / 2 + a * b / 3);
    }
  }
  WriteGmsh(file, mesh);
  scene.object.geometry = MeshFileGeometry{file};
  return scene;
}

// The press is a tenth to five times the thickness deep: a plate stretches from about its thickness
// on.
Scene Membrane(Dice* dice) {
  const double radius = dice->Decades(0.005, 0.1);
  Scene scene = Start(dice, radius, radius * dice->Between(0.1, 0.3));
  scene.name = "membrane";
  const double thickness = radius / dice->Decades(15, 80);
  scene.object.geometry = MembraneGeometry{radius, thickness};
  scene.object.material.poisson_ratio = dice->Between(0.3, 0.49);
  scene.operator_options.press_depth = std::min(thickness * dice->Decades(0.1, 5), 0.15 * radius);
  scene.model.tolerance = dice->Decades(0.02, 0.2);
  return scene;
}

}  // namespace

Scene RandomScene(std::uint32_t seed, const std::filesystem::path& folder) {
  Dice dice(seed);
  Scene scene;
  switch (seed % 7) {
    case 0:
      scene = Rectangle(&dice);
      break;
    case 1:
      scene = Box(&dice);
      break;
    case 2:
      scene = Membrane(&dice);
      break;
    case 3:
      scene = Disc(&dice);
      break;
    case 4:
      scene = Dome(&dice, folder / ("dome-" + std::to_string(seed) + ".msh"));
      break;
    default:
      scene = Polygon(&dice);
  }
  // In scenes with a camera the slave corrects the force for the shape of the tool.
  if (IsPlanar(scene.object.geometry) && dice.Chance(0.5)) {
    scene.name += " before a camera";
    scene.sense.Set(CameraOptions{.camera = Camera{}, .tip = TipTracking{}, .contour = {}});
  }
  return scene;
}

}  // namespace palpate::model_selection
