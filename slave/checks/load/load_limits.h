// Limits of the checks of a load on points. Rows in the evidence are those of the robustness suite.
#pragma once

namespace palpate {

struct LoadLimits {
  // Largest fraction of points that may contradict the others [-]. [tuned: surface_flags_test, many
  // contradicting dots]
  static constexpr double kMaxLeftOut = 0.25;
  // Residual of a load while that without contact is unknown [sigma]. [derived: that of LoadFitter]
  static constexpr double kGoodFit = 3;
  // A nuisance parameter beyond this limit is not zero [sigma]. [tuned: surface_flags_test, a
  // moved rim, a bumped rig, points that move apart]
  static constexpr double kWaldSigmas = 6;
  // Ratio of the relative errors of force and distances [-]. [derived: the force of a stretched
  // membrane is proportional to the third power of the depth, and the depth error of a rotated
  // camera to the square of the distance]
  static constexpr double kForceOfScale = 6;

  // Flat membranes. Largest height of a bulge at rest relative to the thickness [-]. [derived: a
  // shell of this height is a few percent stiffer than the plate]
  static constexpr double kFlatHeight = 0.2;
  // Error of the plate's law relative to the largest deflection, rms [-]. [tuned: radius wrong]
  static constexpr double kModelError = 0.03;

  // Domed membranes.
  // Residual while there is no indentation [sigma]. [tuned: domed_scene_test]
  static constexpr double kGoodDome = 2;
  // Offset of the points at rest from the scene's shape, rms relative to the dome's height [-].
  // [tuned: domed_scene_test]
  static constexpr double kTrueDome = 0.04;
  // Residual relative to the largest deflection, rms [-]. [recorded: 0.11 on a press of
  // membrane_press_rgbd whose force is right]
  static constexpr double kTrueIndentation = 0.15;
};

}  // namespace palpate
