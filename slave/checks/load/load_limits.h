// Limits of the checks of a load on points, as `check` prints them. Rows are those of the
// robustness suite.
#pragma once

namespace palpate {

struct LoadLimits {
  // Share of the points that may contradict the others [-]. [tuned: surface_doubts_test,
  // many contradicting dots]
  static constexpr double kMostLeftOut = 0.25;
  // Residual of a load on a volume, in sigmas [-]. [derived: that of LoadFitter]
  static constexpr double kGoodFit = 3;

  // Flat membranes.
  // Height of a bulge at rest by the thickness [-]. [derived: a shell of this height is some
  // percent stiffer than the plate]
  static constexpr double kFlatHeight = 0.2;
  // Error of the plate's law by the largest deflection, rms [-]. [tuned: radius wrong]
  static constexpr double kModelError = 0.03;
  // Scatter by that at rest [-]. [derived: the chance of two dozen points]
  static constexpr double kClearly = 1.5;

  // Domed membranes.
  // Offset of the points at rest from the scene's shape, rms by the dome's height [-]. [tuned:
  // domed_scene_test]
  static constexpr double kTrueDome = 0.04;
  // Residual by the deepest deflection, rms [-]. [recorded: 0.11 on a press of membrane_press_rgbd
  // whose force is right]
  static constexpr double kTrueDent = 0.15;
};

}  // namespace palpate
