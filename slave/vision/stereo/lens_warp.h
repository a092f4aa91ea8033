// Pictures with and without the distortion of a lens.
#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include "slave/capture/frame_source.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// The straight picture of a lens is a pinhole's of the same size, principal point and mean focal
// length f = sqrt(fx fy): on a plane that the camera looks straight at, at distance Z, each of its
// pixels shows Z / f. What the lens sees beyond the picture's edge there is lost, as is what lies
// outside its invertible range; what it does not see repeats the picture's edge.
//
// Bilinear over a table of a 32nd of a pixel (OpenCV's remap): 640 x 480 grey takes about 0.5 ms.
// Const members are thread-safe.
class LensWarp {
 public:
  // As the pinhole sees what the lens has taken; and the other way round, as a simulated lens shows
  // what a pinhole sees.
  static LensWarp Straightening(const Lens& lens);
  static LensWarp Distorting(const Lens& lens);

  // 8 or 16 bit or float, any channels. Throws std::runtime_error where the picture has another
  // size than the lens.
  [[nodiscard]] cv::Mat Apply(const cv::Mat& picture) const;

 private:
  LensWarp(const cv::Mat& from_x, const cv::Mat& from_y);

  cv::Mat whole_, fraction_;  // where each pixel comes from, in cv::remap's fixed point
};

// The place of p_I [px] of the lens's picture in the straight one; nullopt: it is lost.
std::optional<Eigen::Vector2d> Straight(const Lens& lens, const Eigen::Vector2d& p_I) noexcept;

// The lens of a file of one camera. Throws std::runtime_error as ReadRig does, and for a file of
// two cameras.
Lens ReadLens(const std::filesystem::path& file);

// Pictures of a camera whose lens the scene names come straight to everybody who looks at them:
// what straightens them; empty: the scene names no lens. Throws std::runtime_error naming
// sense.camera.intrinsics: its file is unreadable, no lens, or of two cameras; the filter throws it
// where a picture has another size than the lens.
PictureFilter StraighteningOf(const Camera& camera);

}  // namespace palpate
