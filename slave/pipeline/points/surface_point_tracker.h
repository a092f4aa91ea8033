// From a pair of pictures, or a depth picture, to points of the surface: dots, texture or depth as
// the scene says.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "slave/capture/frame_source.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// One thread at a time.
class SurfacePointTracker {
 public:
  virtual ~SurfacePointTracker() = default;
  SurfacePointTracker() = default;
  SurfacePointTracker(const SurfacePointTracker&) = delete;
  SurfacePointTracker& operator=(const SurfacePointTracker&) = delete;
  // Never throws; allocation-free after the first pictures. Valid until the next call.
  virtual const SurfaceObservation& Process(const StereoPair& pair) noexcept = 0;
  // The rest frame is taken anew: nothing must touch the object.
  virtual void Reset() = 0;
  [[nodiscard]] virtual bool at_rest_known() const = 0;
  // Where point `i` of the last observation is in the left picture [px]; not finite: unseen.
  [[nodiscard]] virtual Eigen::Vector2d PlaceInPicture(std::size_t i) const noexcept = 0;
  // Where p_S [m] would be in the left picture [px], whether or not it lies inside; nullopt: behind
  // the camera.
  [[nodiscard]] virtual std::optional<Eigen::Vector2d> Project(
      const Eigen::Vector3d& p_S) const noexcept = 0;
  // Radius that the followed points have in the left picture, about [px]: half a window's edge.
  [[nodiscard]] virtual double radius_px() const = 0;
  // Pictures before the rest frame is known, at least.
  [[nodiscard]] virtual int rest_pictures() const = 0;
  // What the checks of the last picture took, part of Process [us].
  [[nodiscard]] virtual double checks_us() const = 0;
  // Name of the stage in reports: dots, texture, depth.
  [[nodiscard]] virtual std::string stage() const = 0;
};

// `rig`: as the source has it; unused for depth pictures. Throws std::runtime_error or
// std::invalid_argument naming the key.
std::unique_ptr<SurfacePointTracker> MakeSurfacePointTracker(const Scene& scene,
                                                             const StereoRig& rig);
// How many pictures of what the rest frame takes, one clause.
std::string RestInWords(const SurfacePointTracker& eyes);
// Beyond this depth [m] pictures show no object: twice as far as its origin, 1 m at least. For
// scenes of depth pictures.
double FarthestDepth(const Scene& scene);
// What may be wrong where the scene's eyes do not find what they look for, one clause; lives on.
std::string_view WhyNotFound(const Scene& scene);
// What may be wrong with the pictures where few windows of texture are found, likewise.
std::string_view WhyFewWindows();
// The rig that the scene names, or that of its simulated pair. Throws std::invalid_argument naming
// the key.
StereoRig RigOf(const Scene& scene);
// Throws std::runtime_error where pictures of `pair` have not the size that the rig was calibrated
// for; both sizes are named. Depth pictures of any size fit.
void RequireRigFits(const Scene& scene, const StereoRig& rig, const StereoPair& pair);

}  // namespace palpate
