// Finds points of the surface in a pair of images or a depth image: dots, texture or depth, as the
// scene defines.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "slave/capture/frame_source.h"
#include "slave/checks/points/points_checks.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// Base class of the trackers: runs the checks and measures their time. One thread at a time.
class SurfacePointTracker {
 public:
  virtual ~SurfacePointTracker() = default;
  SurfacePointTracker(const SurfacePointTracker&) = delete;
  SurfacePointTracker& operator=(const SurfacePointTracker&) = delete;
  // Never throws; allocation-free after the first images. Valid until the next call.
  virtual const SurfaceObservation& Process(const StereoPair& pair) noexcept = 0;
  // Measures the rest shape again; the object must not be in contact.
  virtual void Reset();
  [[nodiscard]] virtual bool at_rest_known() const = 0;
  // Position of point `i` of the last observation in the left image [px]; not finite: not visible.
  [[nodiscard]] virtual Eigen::Vector2d PlaceInImage(std::size_t i) const noexcept = 0;
  // Projection of p_S [m] into the left image [px], inside or not; nullopt: behind the camera.
  [[nodiscard]] virtual std::optional<Eigen::Vector2d> Project(
      const Eigen::Vector3d& p_S) const noexcept = 0;
  // Approximate radius of the tracked points in the left image [px]: half a window's edge.
  [[nodiscard]] virtual double radius_px() const = 0;
  // Smallest number of images before the rest shape is known.
  [[nodiscard]] virtual int rest_images() const = 0;
  // Time of the checks of the last image, part of Process [us].
  [[nodiscard]] double checks_us() const { return checks_us_; }
  // The surface at rest compared with the scene's body; nullopt: not known yet, or not compared.
  [[nodiscard]] const std::optional<RestSurface>& rest() const { return rest_; }
  // Name of the stage in reports: dots, texture, depth.
  [[nodiscard]] virtual std::string stage() const = 0;

 protected:
  // Throws std::runtime_error or std::invalid_argument: a mesh that cannot be read.
  SurfacePointTracker(const Scene& scene, const StereoRig& rig);

  // `seen` as the observation of `pair`, with the results of the checks.
  const SurfaceObservation& Checked(const SurfaceObservation& seen, const StereoPair& pair);
  [[nodiscard]] const SurfaceObservation& checked() const { return checked_; }

 private:
  std::optional<RestSurface> rest_;
  Checks<PointsSample> checks_;
  SurfaceObservation checked_;
  double checks_us_ = 0;
};

// `rig`: that of the source; unused for depth images. Throws std::runtime_error or
// std::invalid_argument naming the key.
std::unique_ptr<SurfacePointTracker> MakeSurfacePointTracker(const Scene& scene,
                                                             const StereoRig& rig);
// Returns a clause with the number of images that the baseline needs.
std::string RestInWords(const SurfacePointTracker& tracker);
// Depths beyond this [m] are not used: twice the distance of the object's origin, 1 m at least. For
// scenes with depth images.
double MaxDepth(const Scene& scene);
// Possible reasons why the points are not found, one clause with static lifetime.
std::string_view WhyNotFound(const Scene& scene);
// Possible reasons why few windows of texture are found, one clause with static lifetime.
std::string_view WhyFewWindows();
// The rig of the scene, or that of its simulated pair. Throws std::invalid_argument naming the key.
StereoRig RigOf(const Scene& scene);
// Throws std::runtime_error if images of `pair` have another size than the rig; both sizes are
// named. Depth images of any size fit.
void RequireRigFits(const Scene& scene, const StereoRig& rig, const StereoPair& pair);

}  // namespace palpate
