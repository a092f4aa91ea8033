#include "tests/campaigns/coverage/random_press.h"

#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <spdlog/fmt/fmt.h>

#include "tests/campaigns/robustness/stages.h"
#include "tests/support/dice.h"

namespace palpate::coverage {
namespace {

using robustness::Overrides;

constexpr double kTensionStated = 0.5;        // one sigma, of itself
constexpr double kFoam = 4e4, kRubber = 1e6;  // moduli [Pa]
constexpr double kWide = 0.1;  // share of the presses that go beyond the model's range

// Returns the quantile `below` of the standard normal distribution.
double NormalQuantile(double below) {
  double low = -8, high = 8;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (std::erfc(-middle / std::numbers::sqrt2) / 2 < below ? low : high) = middle;
  }
  return low;
}

// The van der Corput sequence with a shift: any part of it is spread evenly over (0, 1).
double Spread(std::uint32_t seed, int number) {
  double share = Dice(seed).Share();
  double digit = 0.5;
  for (auto rest = static_cast<unsigned>(number); rest > 0; rest /= 2, digit /= 2) {
    if (rest % 2 == 1) share += digit;
  }
  return share - std::floor(share);
}

struct StatedMaterial {
  double modulus = 0, tolerance = 0;
};
StatedMaterial DrawMaterial(Dice* dice, double least, double most) {
  return {dice->Decades(least, most), dice->Between(0.01, 0.08)};
}

std::string Vector(double x, double y) {
  return fmt::format("[{:.9g}, {:.9g}]", x, y);
}
std::string Vector(double x, double y, double z) {
  return fmt::format("[{:.9g}, {:.9g}, {:.9g}]", x, y, z);
}

void AddImages(Dice* dice, Overrides* scene) {
  scene->push_back(fmt::format("site.noise={:.3g}", dice->Between(0.7, 4)));
  scene->push_back(fmt::format("site.blur={:.3g}", dice->Between(0.5, 1)));
}

// Draws a block, a wedge or a disc, with a random tool, place and depth.
Overrides Planar(Dice* dice, const StatedMaterial& stated, double wide) {
  const double size = dice->Decades(5e-3, 0.2);
  const double pixel = size / dice->Between(230, 310);
  double height = size * dice->Between(0.6, 1), x = size * dice->Between(0.3, 0.7);
  // The simulated body is plane: a sheet so thin that plane stress is exact for it.
  const double thickness = size * dice->Between(0.002, 0.005);
  Overrides scene;
  const int kind = dice->Whole(0, 2);
  if (kind == 0) {
    scene.push_back(
        fmt::format("object.geometry={{rectangle: {{width: {:.9g}, height: {:.9g}, thickness: "
                    "{:.9g}}}}}",
                    size, height, thickness));
  } else if (kind == 1) {
    const double inset = size * dice->Between(0, 0.15);
    scene.push_back(
        fmt::format("object.geometry={{polygon: {{points: [{}, {}, {}, {}], thickness: {:.9g}}}}}",
                    Vector(0, 0), Vector(size, 0), Vector(size - inset, height),
                    Vector(inset, height), thickness));
  } else {
    height = size;
    x = 0.5 * size;
    scene.push_back(fmt::format("object.geometry={{disc: {{radius: {:.9g}, thickness: {:.9g}}}}}",
                                0.5 * size, thickness));
    scene.push_back(fmt::format("object.fixed={{arc: {{centre: -90 deg, half_angle: {:.9g}}}}}",
                                dice->Between(0.4, 1.1)));
  }
  // A disc's frame is at its centre.
  const double left = kind == 2 ? -0.5 * size : 0, bottom = kind == 2 ? -0.5 * size : 0;
  const double above = 0.06 * size;
  scene.push_back("manipulator.home=" + Vector(left + x, bottom + height + above, 0));
  scene.push_back(
      "sense.camera.pose={translation: " + Vector(left + 0.5 * size, bottom + 0.6 * size, 0) + "}");
  scene.push_back(fmt::format("sense.camera.pixel={:.9g}", pixel));
  scene.push_back(fmt::format("object.material.young_modulus={:.9g}", stated.modulus));
  scene.push_back(fmt::format("object.material.tolerance={:.9g}", stated.tolerance));
  scene.push_back(fmt::format("object.material.poisson_ratio={:.3g}", dice->Between(0.3, 0.49)));
  scene.push_back(fmt::format("tool.width={:.9g}", size * dice->Between(0.05, 0.12)));
  scene.push_back(fmt::format("operator.press.depth={:.9g}",
                              wide > 0 ? wide * size : size * dice->Between(0.02, 0.07)));
  scene.push_back(fmt::format("model.elements={}", dice->Whole(80, 300)));
  const auto off = [&] { return pixel * dice->Between(-1, 1); };
  const double off_x = off();
  scene.push_back("site.misplacement=" + Vector(off_x, off()));
  AddImages(dice, &scene);
  return scene;
}

Overrides Membrane(Dice* dice, const StatedMaterial& stated, double wide) {
  const double radius = dice->Between(0.03, 0.045);
  const double place = radius * dice->Between(0, 0.55);
  const double around = dice->Between(0, 2 * std::numbers::pi);
  const double thickness = radius / dice->Between(30, 60);
  Overrides scene{fmt::format("object.geometry={{membrane: {{radius: {:.9g}, thickness: {:.9g}}}}}",
                              radius, thickness),
                  "manipulator.home=" +
                      Vector(place * std::cos(around), place * std::sin(around), 0.08 * radius),
                  fmt::format("object.material.young_modulus={:.9g}", stated.modulus),
                  fmt::format("object.material.tolerance={:.9g}", stated.tolerance),
                  fmt::format("object.material.poisson_ratio={:.3g}", dice->Between(0.35, 0.47)),
                  fmt::format("tool.width={:.9g}", radius * dice->Between(0.08, 0.15)),
                  fmt::format("operator.press.depth={:.9g}",
                              radius * (wide > 0 ? 0.26 : dice->Between(0.05, 0.13)))};
  if (dice->Chance(0.3)) {
    const double stretched = stated.modulus * thickness;
    scene.push_back(fmt::format("model.prestress={:.9g}", stretched * dice->Decades(1e-4, 3e-3)));
  }
  if (dice->Chance(0.3)) {
    scene.emplace_back("sense.points={track: texture}");
  } else {
    scene.push_back("sense.points.spacing=" + Vector(0.38 * radius, 0.256 * radius));
    scene.push_back(fmt::format("sense.points.radius={:.9g}", 0.05 * radius));
  }
  AddImages(dice, &scene);
  return scene;
}

// A block whose modulus is between those of foam and rubber. Two fingertips press it from opposite
// sides, anywhere from near an edge to the centre, with their tips, pads or sides.
Overrides Pinch(Dice* dice, const StatedMaterial& stated, double wide) {
  const double length = dice->Between(0.04, 0.08), width = dice->Between(0.04, 0.08),
               height = dice->Between(0.045, 0.08);
  const auto pose = [&](double x, double turn) {
    const double y = width * dice->Between(0.2, 0.8), z = height * dice->Between(0.45, 0.75);
    const double roll = dice->Between(-30, 30), tilt = 115 + dice->Between(-30, 25);
    return fmt::format("{{translation: {}, rotation: [{:.9g} deg, {:.9g} deg, {:.9g} deg]}}",
                       Vector(x, y, z), roll, tilt, turn);
  };
  // Limits the force to a few newtons for any modulus.
  const double least = std::min(1.0, std::pow(kFoam / stated.modulus, 0.75));
  const double depth = wide > 0 ? 0.012 : least * dice->Between(0.003, 0.009);
  return {fmt::format("object.geometry={{box: {{size: {}, cells: [6, 6, 6]}}}}",
                      Vector(length, width, height)),
          "sense.tactile.fingers.ff.pose=" + pose(length + 0.013, 0),
          "sense.tactile.fingers.th.pose=" + pose(-0.013, 180),
          fmt::format("object.material.young_modulus={:.9g}", stated.modulus),
          fmt::format("object.material.tolerance={:.9g}", stated.tolerance),
          fmt::format("object.material.poisson_ratio={:.3g}", dice->Between(0.05, 0.35)),
          fmt::format("operator.press.depth={:.9g}", depth)};
}

// Draws the errors of the stated finger poses, of the size that the scene states for them.
std::vector<Eigen::AngleAxisd> DrawTurns(Dice* dice, const Tactile& tactile) {
  std::vector<Eigen::AngleAxisd> turns;
  for (std::size_t i = 0; i < tactile.fingers.size(); ++i) {
    const double x = dice->Normal(), y = dice->Normal(), z = dice->Normal();
    const Eigen::Vector3d turn = tactile.pose_tolerance * Eigen::Vector3d(x, y, z);
    turns.emplace_back(turn.norm(), turn.stableNormalized());
  }
  return turns;
}

// Turns the fingers about the apices of their pads, so that the contact points do not move.
void TurnFingers(const std::vector<Eigen::AngleAxisd>& turns, double radius, TactileFrame* frame) {
  const Eigen::Translation3d apex(0, 0, -radius);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    std::optional<Eigen::Isometry3d>& X_SF = frame->fingers[i].X_SF;
    if (X_SF) *X_SF = *X_SF * apex * turns[i] * apex.inverse();
  }
}

Scene Make(const std::string& base, Overrides overrides, Dice* dice, int number) {
  overrides.push_back(fmt::format("site.seed={}", dice->Whole(1, 1 << 20)));
  Scene scene = robustness::Shipped(base, overrides);
  scene.name = fmt::format("{} {}", base, number);
  return scene;
}

}  // namespace

RandomPress DrawPress(const std::string& sense, std::uint32_t seed, int number) {
  Dice dice(seed * 7919U + static_cast<std::uint32_t>(number));
  RandomPress press;
  const double wide = dice.Chance(kWide) ? 0.12 : 0;
  StatedMaterial stated;
  Scene scene;
  if (sense == "camera") {
    stated = DrawMaterial(&dice, 5e3, 2e6);
    scene = Make("silicone-block", Planar(&dice, stated, wide), &dice, number);
  } else if (sense == "pairs") {
    stated = DrawMaterial(&dice, 1e6, 3e7);
    scene = Make("rubber-membrane", Membrane(&dice, stated, wide), &dice, number);
  } else if (sense == "fingertips") {
    stated = DrawMaterial(&dice, 3e3, wide > 0 ? 2e5 : kRubber);
    scene = Make("foam-cube", Pinch(&dice, stated, wide), &dice, number);
  } else {
    throw std::invalid_argument("--sense = " + sense + ": expected camera, pairs and fingertips");
  }
  press.modulus_error = stated.tolerance * NormalQuantile(Spread(seed, number));
  scene.object.material.young_modulus *= 1 + press.modulus_error;
  // The tension at rest in the scene has a relative error of kTensionStated (one sigma).
  const double tension = scene.model.prestress;
  scene.model.prestress *= std::max(0.1, 1 + kTensionStated * dice.Normal());
  if (tension > 0) scene.name += " tight";
  press.alteration.tell = [stated, tension](Scene& scene) {
    scene.object.material.young_modulus = stated.modulus;
    scene.model.prestress = tension;
  };
  if (const auto* tactile = scene.sense.Find<Tactile>()) {
    press.alteration.touch = [turns = DrawTurns(&dice, *tactile), radius = tactile->finger_radius](
                                 const robustness::Moment&, TactileFrame& frame) {
      TurnFingers(turns, radius, &frame);
    };
  }
  if (sense == "camera") {
    press.stage = robustness::MakeCameraStage(std::move(scene), {4, 22, 8, 12, 3});
  } else if (sense == "fingertips") {
    const auto way = static_cast<std::size_t>(dice.Whole(30, 150));
    press.stage = robustness::MakeTouchStage(std::move(scene), {70, way, 25, way, 10});
  } else if (dice.Chance(0.25)) {
    press.stage = robustness::MakeDepthStage(std::move(scene), {8, 10, 5, 6, 2});
  } else {
    press.stage = robustness::MakePairStage(std::move(scene), {16, 10, 5, 6, 2});
  }
  return press;
}

}  // namespace palpate::coverage
