// The simulator of a scene with fingertips: a soft body with a large-strain constitutive model on
// its own mesh, in contact with simulated fingertips. It is visible only through tactile samples;
// its truth is for reports.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/press_motion.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/simulator/fingertips/site_mesh.h"

namespace palpate {

// The fingers are rigid (paper B, equation 4) and stick to the surface. A separate thread solves
// contacts along approach() in advance (LoadPathCache) on its own mesh, and they are interpolated.
// Sideways motion of a finger in contact uses a linear stiffness, 2 (1 - nu) / (2 - nu) of the
// normal one (Mindlin 1949), and slips beyond a friction of 1. Gravity and inertia are neglected:
// the foams of the material files sink by less than a percent of their height under their own
// weight. On the paper's foam cube forces at depths of 1 to 3 mm are 5 to 11 % above those on a
// mesh with six times the nodes; on mesh files, whose edges are only halved, a third above.
class TactileSite final : public SimulatedEnvironment {
 public:
  // Takes a few milliseconds; a thread solves the first contact meanwhile. Throws
  // std::invalid_argument with the key if the scene cannot be simulated: an object that is not a
  // volume or has no fixed part, a fingertip that is inside it at home.
  explicit TactileSite(const Scene& scene, const SiteResolution& resolution = {});
  ~TactileSite() override;

  // The manipulator moves the tip, which is the apex of the first finger's pad, to this position,
  // frame S [m]. Thread-safe. WhenUnsolved::kWait: returns at once, unless the contact is deeper
  // than the solved depth: then it waits (at worst about a second per millimetre).
  // WhenUnsolved::kUseNearest, for an operator who must not be delayed: an unsolved contact is
  // replaced by that of the nearest solved position, and truth().solved is false until it is
  // solved.
  void MoveTool(const Eigen::Vector3d& p_S_tip,
                WhenUnsolved when_unsolved = WhenUnsolved::kWait) override;
  // Solves the scene's own contact to its full depth; takes as long as this solution.
  void SolveAhead() override;
  [[nodiscard]] Truth truth() const override;
  // The nodes of a box are denser near the contact, so they move over the surface when the contact
  // moves (5 mm from the last point, or more).
  [[nodiscard]] SurfaceMesh TrueSurface() const override;
  std::unique_ptr<TactileSource> OpenFingertips(const Scene& scene,
                                                const std::optional<ScriptedRun>& run) override;
  // Unit vector, frame S, of expected contacts: from the first finger's pad into the object's
  // surface.
  [[nodiscard]] Eigen::Vector3d approach() const;
  // Returns the distance along approach() from home to the first touch [m]; infinity: no finger
  // ever touches.
  [[nodiscard]] double gap() const;
  // The tip at home, frame S [m].
  [[nodiscard]] Eigen::Vector3d home() const;
  // One sample of every finger; the simulation advances by one sample period (1 / rate). One
  // thread; the same calls in the same order give the same samples.
  TactileFrame TakeSample(Time now);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Contacts for runs without an operator. First a rest at home, while the baseline is measured and
// for 0.2 s more. Each contact: along TactileSite::approach() to operator.press.depth beyond the
// first contact in a minimum-jerk ramp whose peak speed is operator.press.speed, or
// manipulator.max_speed if that is less; a hold of 1 s; the same ramp back; 0.5 s at home.
//
// Throws std::invalid_argument naming the key: no object in front of the fingers.
PressMotion ScriptedTouch(const TactileSite& site, const Scene& scene, int presses);
// Returns a source of its samples, as fast as they can be computed; sensed_at starts at Time{}.
// `site` of that scene must outlive them.
std::unique_ptr<TactileSource> Play(TactileSite& site, const Scene& scene,
                                    const PressMotion& motion);

}  // namespace palpate
