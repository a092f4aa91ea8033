// The simulated environment of one camera: an independent and finer solution of the contact, which
// the slave observes only through camera images. Its true force is for reports, never for an
// estimator.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

// The contact is a rigid flat or round tool that is bonded to the boundary (a round one where it
// touches). Its centre is where the tool's path first entered the body. It lasts until the tip
// leaves through the surface there. Linear elasticity (slave/reference/planar/plane_elasticity.h),
// also for large indentations; the stiffness is within 1e-3 of the continuum's. An embryo
// (`site.embryo`) also stiffens and is punctured (slave/simulator/camera/embryo.h): afterwards it
// is at rest, with the tool inside, until the tool has left; the next insertion is into another
// embryo. A moving body moves its contact; in its images everything except the tool moves with it.
class SimulatedSite final : public SimulatedEnvironment {
 public:
  // Builds the simulation and solves the contact straight ahead of manipulator.home (under 0.2 s).
  // Throws std::invalid_argument naming the key if the scene cannot be simulated: outline from an
  // image, nothing fixed, nodes fixed by number, pose out of the plane, an outline that intersects
  // itself.
  explicit SimulatedSite(const Scene& scene);
  ~SimulatedSite() override;

  // Moves the tool; called by the manipulator. Thread-safe; takes microseconds: during the approach
  // a separate thread solves the contact. Only a tip that reaches the surface at another point than
  // expected waits for the solution (10 to 60 ms). Positions that are not finite, or a million body
  // sizes away, are ignored. A tip that starts inside has no contact until it has left. This is
  // independent of `when_unsolved`.
  void MoveTool(const Eigen::Vector3d& p_S_tip,
                WhenUnsolved when_unsolved = WhenUnsolved::kWait) override;
  // From now on the position of a moving body (`site.motion`) is that at `t` [s] after its rest,
  // instead of the clock: for scripts.
  void SetTime(double t);
  [[nodiscard]] Eigen::Vector3d HandOffset(double t) const override;
  [[nodiscard]] Truth truth() const override;
  [[nodiscard]] std::optional<Eigen::Vector3d> goal() const override;
  void SolveAhead() override {}
  std::unique_ptr<FrameSource> OpenCamera(const Scene& scene,
                                          const std::optional<ScriptedRun>& run) override;
  // Takes an image of the present state, with the scene's lens if there is one, and undistorted as
  // a FrameSource does it: 8 bit grey. Thread-safe against MoveTool; call from one thread. The same
  // calls in the same order give the same images. A millisecond or two.
  cv::Mat TakeImage();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
