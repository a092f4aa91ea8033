// The simulated slave site: a world of its own, with a finer and independent solution of the
// pressed body, that shows itself only through camera images. Its true force is for reports, never
// for an estimator.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/site/simulated_environment.h"

namespace palpate {

// The contact is a rigid flat or round tool, bonded to the boundary (round: where it touches)
// centred where the tip's way first entered the body, until the tip comes out through the surface
// there. Linear elasticity (slave/site/camera/plane_elasticity.h), so large presses are
// extrapolated, as deep as one likes; the stiffness is within 1e-3 of the continuum's. An embryo
// (`site.embryo`) stiffens and is punctured besides (slave/site/camera/embryo.h): from then on it
// rests, with the tool inside, until the tool has come out; the next insertion is into another one.
// A body that moves takes its contact along; in its images all but the tool's place moves with it.
class SimulatedSite final : public SimulatedEnvironment {
 public:
  // Builds the world and solves the contact straight ahead of manipulator.home (under 0.2 s).
  // Throws std::invalid_argument naming the key where the scene cannot be simulated: no tool width,
  // outline from an image, nothing held, nodes held by number, no camera or no size, pose out of
  // the plane, an outline that crosses itself.
  explicit SimulatedSite(const Scene& scene);
  ~SimulatedSite() override;

  // The manipulator carries the tool here. Thread-safe; microseconds: on approach the contact is
  // solved by a thread of its own. Only a tip that reaches the surface at another place than it was
  // heading for waits for the solution (10 to 60 ms). Places that are not finite, or a million body
  // sizes away, are ignored. A tip that starts inside touches nothing before it has come out.
  // So it is whatever the patience.
  void MoveTool(const Eigen::Vector3d& p_S_tip, Patience patience = Patience::kWaits) override;
  // Where a body that moves (`site.motion`) is from now on is that of `t` [s] after its rest, not
  // of the clock: for scripts.
  void SetTime(double t);
  [[nodiscard]] Truth truth() const override;
  [[nodiscard]] std::optional<Eigen::Vector3d> goal() const override;
  std::unique_ptr<FrameSource> OpenCamera(const Scene& scene, const Pace& pace) override;
  // Takes an image of the world as it is now, through the scene's lens if it names one, and
  // straightened as a FrameSource does it: 8 bit grey. Thread-safe against MoveTool; call from one
  // thread. The same calls in the same order give the same images. A millisecond or two.
  cv::Mat TakePicture();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace palpate
