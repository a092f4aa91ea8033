// The simulator of a scene with a stereo pair: a membrane with a large-strain constitutive model on
// its own mesh, or a textured target on its path. It is visible only through images.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/reference/membrane/pressed_membrane.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

struct StereoImages {
  cv::Mat left, right;  // 8 bit grey
};

// The scene determines the simulated object:
//
// - A membrane under a flat round tool of the scene's width, with the tension at rest of the model
//   (`model.prestress`). On its inner face are dark dots (`track: dots`) or a fine texture (`track:
//   texture`). The tool has no friction: it presses at the position of its tip, with the depth of
//   the tip below the rest plane z_O = 0. Presses are solved in advance (PressCache) and
//   interpolated (Indentation): exactly at the radius of manipulator.home, elsewhere within 0.6 %
//   of the force.
// - Any other object with `track: texture`: the textured target of paper C's second experiment on
//   its path about the origin of O, independent of the object's shape. Frame B has the orientation
//   of O; time advances by 1 / rate from one pair of images to the next.
class StereoSite final : public SimulatedEnvironment {
 public:
  // Throws std::invalid_argument naming the key where the scene cannot be simulated: no simulated
  // pair (SimulatedRig), no points or no tool, an object that cannot carry the
  // points, dots beyond the rim.
  explicit StereoSite(const Scene& scene, const simulation::MembraneResolution& resolution = {});
  ~StereoSite() override;

  // WhenUnsolved::kWait: returns at once, unless the contact is deeper than the solved depth. A
  // target has no contact. WhenUnsolved::kUseNearest, for an operator who must not be delayed:
  // never waits. If the contacts around the tool are not solved to its depth, or it is nearer to
  // the rim than contacts are solved, they are solved next (with a log line, once per radius).
  // Until then truth().solved is false: the images and the force are those of the nearest solved
  // contact, extrapolated beyond its depth. Afterwards the membrane jumps to the true solution.
  void MoveTool(const Eigen::Vector3d& p_S_tip,
                WhenUnsolved when_unsolved = WhenUnsolved::kWait) override;
  // Solves the scene's own contact now to its full depth, and starts to solve a dozen others in the
  // background, about a second each. Unsolved contacts are approximated.
  void SolveAhead() override;
  [[nodiscard]] Truth truth() const override;
  // nullopt: a membrane.
  [[nodiscard]] std::optional<TargetTruth> target() const override;
  // Displacement of the membrane's point that rests at p_O [m] on the inner face.
  [[nodiscard]] Eigen::Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const override;
  std::unique_ptr<StereoSource> OpenPair(const Scene& scene,
                                         const std::optional<ScriptedRun>& run) override;
  // Both cameras at once; noise, blur and light as in the scene's `site`. One thread; the same
  // calls in the same order give the same images.
  StereoImages TakeImages();
  // The pair as it really is.
  [[nodiscard]] const StereoRig& rig() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
