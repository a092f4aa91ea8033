// The simulator of a scene with fingertips: a soft body under a large-strain law on a mesh of its
// own, pressed by simulated fingertips. It shows itself through tactile samples only; its truth is
// for reports.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/mesh/solid_mesh.h"
#include "slave/capture/tactile_frame.h"
#include "slave/scene/scene.h"
#include "slave/site/fingertips/site_mesh.h"
#include "slave/site/simulated_environment.h"

namespace palpate {

// The fingers are rigid (paper B, equation 4) and stick to what they touch. Presses along
// approach() are solved ahead by a thread of its own (LoadPathCache) on a
// mesh of its own and interpolated; sideways motion of a finger in contact is answered by a linear
// stiffness, 2 (1 - nu) / (2 - nu) of the normal one (Mindlin 1949), and slips beyond a friction of
// 1. Gravity and inertia are left out: the material files' foams sink by less than a percent of
// their height under their own weight. On the paper's foam
// cube forces at depths of 1 to 3 mm are 5 to 11 % above those on a mesh with six times the nodes;
// on mesh files, whose edges are only halved, a third above.
class TactileSite final : public SimulatedEnvironment {
 public:
  // A few milliseconds; the first press is solved in the background from here on. Throws
  // std::invalid_argument naming the key where the scene cannot be simulated: no fingertips, an
  // object that is no volume or is held nowhere, a fingertip that is inside it at home.
  explicit TactileSite(const Scene& scene, const SiteResolution& resolution = {});
  ~TactileSite() override;

  // The manipulator carries the hand here: the tip, which is the apex of the first finger's pad,
  // frame S [m]. Thread-safe. Short, unless a press is deeper than what is solved so far: then it
  // waits (about a second per millimetre at worst), whatever the patience.
  void MoveTool(const Eigen::Vector3d& p_S_tip, Patience patience = Patience::kWaits) override;
  // A press is as slow as its solution: the scene's own, to its full depth, is solved.
  void SolveAhead() override;
  [[nodiscard]] Truth truth() const override;
  std::unique_ptr<TactileSource> OpenFingertips(const Scene& scene, const Pace& pace) override;
  // Unit vector, frame S, in which presses are expected: from the first finger's pad into the
  // object's surface.
  [[nodiscard]] Eigen::Vector3d approach() const;
  // Way along approach() from home until a finger touches [m]; infinity: none ever does.
  [[nodiscard]] double gap() const;
  // The tip while the hand is at home, frame S [m].
  [[nodiscard]] Eigen::Vector3d home() const;
  // One sample of every finger; the world moves on by one sample period (1 / rate). One thread; the
  // same calls in the same order give the same samples.
  TactileFrame TakeSample(Time now);
  // Surface of the true body at rest and as it is deformed now, frame S [m]; same triangles. The
  // nodes of a box gather where it is pressed, so they move over the surface when the hand presses
  // elsewhere (5 mm beside the last place, or more). For reports and for the images of a virtual
  // depth camera.
  [[nodiscard]] SurfaceMesh rest_surface() const;
  [[nodiscard]] std::vector<Eigen::Vector3d> DeformedSurface() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
