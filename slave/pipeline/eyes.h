// From a pair of pictures, or a depth picture, to points of the surface: dots, texture or depth as
// the scene says.
#pragma once

#include <memory>
#include <string>

#include "shared/scene/scene.h"
#include "slave/capture/stereo_source.h"
#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

class Eyes {
 public:
  virtual ~Eyes() = default;
  Eyes() = default;
  Eyes(const Eyes&) = delete;
  Eyes& operator=(const Eyes&) = delete;
  // Never throws; allocation-free after the first pictures. Valid until the next call.
  virtual const SurfaceObservation& Look(const StereoPair& pair) noexcept = 0;
  // The rest frame is taken anew: nothing must touch the object.
  virtual void Reset() = 0;
  [[nodiscard]] virtual bool at_rest_known() const = 0;
  // Where point `i` of the last observation is in the left picture [px]; not finite: unseen.
  [[nodiscard]] virtual Eigen::Vector2d PlaceInPicture(std::size_t i) const noexcept = 0;
  // Name of the stage in reports: dots, texture, depth.
  [[nodiscard]] virtual std::string stage() const = 0;
};

// `rig`: as the source has it; unused for depth pictures. Throws std::runtime_error or
// std::invalid_argument naming the key.
std::unique_ptr<Eyes> MakeEyes(const Scene& scene, const StereoRig& rig);
// The rig that the scene names, or that of its simulated pair (StereoSite::rig()). Throws.
StereoRig RigOf(const Scene& scene);

}  // namespace palpate
