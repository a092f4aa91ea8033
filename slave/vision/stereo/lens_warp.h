// Adds or removes the distortion of a lens.
#pragma once

#include <filesystem>

#include <opencv2/core/mat.hpp>

#include "slave/capture/frame_source.h"
#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// The straight image of a lens is that of a pinhole camera with the same size, principal point and
// mean focal length f = sqrt(fx fy): on a plane perpendicular to the view at distance Z each pixel
// shows Z / f. The parts that the lens sees beyond the edge of the straight image, or outside of
// its invertible range, are lost; pixels that it does not see repeat the image's edge.
//
// Bilinear with a table of 1/32 pixel (OpenCV's remap): 640 x 480 grey takes about 0.5 ms. Const
// members are thread-safe.
class LensWarp {
 public:
  // Undistorts an image of the lens; and the reverse, for a simulated lens.
  static LensWarp Straightening(const Lens& lens);
  static LensWarp Distorting(const Lens& lens);

  // 8 or 16 bit or float, any channels. Throws std::runtime_error if the image has another size
  // than the lens.
  [[nodiscard]] cv::Mat Apply(const cv::Mat& image) const;

 private:
  LensWarp(const cv::Mat& from_x, const cv::Mat& from_y);

  cv::Mat whole_, fraction_;  // source of each pixel, in cv::remap's fixed point
};

// Position of p_I [px] of the lens's image in the undistorted one; nullopt: outside.
std::optional<Eigen::Vector2d> Straight(const Lens& lens, const Eigen::Vector2d& p_I) noexcept;

// The lens of a file of one camera. Throws std::runtime_error as ReadRig does, and for a file of
// two cameras.
Lens ReadLens(const std::filesystem::path& file);

// The filter that undistorts the images of a camera with a lens file in the scene; empty: the scene
// has no lens. Throws std::runtime_error naming sense.camera.intrinsics: its file is unreadable,
// not a lens, or of two cameras; the filter throws it if an image has another size than the lens.
ImageFilter StraighteningOf(const Camera& camera);

}  // namespace palpate
