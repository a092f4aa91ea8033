#include "slave/vision/stereo/lens_warp.h"

#include <cmath>
#include <stdexcept>
#include <string>

#include <opencv2/imgproc.hpp>

namespace palpate {
namespace {

double MeanFocal(const Lens& lens) {
  return std::sqrt(lens.fx * lens.fy);
}

// Returns the place in the lens's image that the straight image shows at `p_I`.
std::optional<Eigen::Vector2d> Bent(const Lens& lens, const Eigen::Vector2d& p_I) {
  const double f = MeanFocal(lens);
  return Project(lens, Eigen::Vector3d((p_I.x() - lens.cx) / f, (p_I.y() - lens.cy) / f, 1));
}

// Returns the source of each pixel of a warped image, as two images of x and y.
template <typename From>
std::array<cv::Mat, 2> Sources(const std::array<int, 2>& size, const From& from) {
  const cv::Mat nowhere(size[1], size[0], CV_32F, cv::Scalar(-1));
  std::array<cv::Mat, 2> sources{nowhere.clone(), nowhere.clone()};
  for (int y = 0; y < size[1]; ++y) {
    for (int x = 0; x < size[0]; ++x) {
      const auto at = from(Eigen::Vector2d(x, y));
      if (!at) continue;
      sources[0].at<float>(y, x) = static_cast<float>(at->x());
      sources[1].at<float>(y, x) = static_cast<float>(at->y());
    }
  }
  return sources;
}

[[noreturn]] void Refuse(const Camera& camera, const std::exception& error) {
  throw std::runtime_error("sense.camera.intrinsics = " + camera.lens.string() + ": " +
                           error.what());
}

LensWarp Read(const Camera& camera) {
  try {
    return LensWarp::Straightening(ReadLens(camera.lens));
  } catch (const std::runtime_error& error) {
    Refuse(camera, error);
  }
}

}  // namespace

std::optional<Eigen::Vector2d> Straight(const Lens& lens, const Eigen::Vector2d& p_I) noexcept {
  const auto ray = RayOf(lens, p_I);
  if (!ray) return std::nullopt;
  return Eigen::Vector2d(lens.cx, lens.cy) + MeanFocal(lens) * *ray;
}

LensWarp::LensWarp(const cv::Mat& from_x, const cv::Mat& from_y) {
  cv::convertMaps(from_x, from_y, whole_, fraction_, CV_16SC2);
}

LensWarp LensWarp::Straightening(const Lens& lens) {
  const auto [x, y] = Sources(lens.size, [&](const auto& p_I) { return Bent(lens, p_I); });
  return {x, y};
}

LensWarp LensWarp::Distorting(const Lens& lens) {
  const auto [x, y] = Sources(lens.size, [&](const auto& p_I) { return Straight(lens, p_I); });
  return {x, y};
}

cv::Mat LensWarp::Apply(const cv::Mat& image) const {
  if (image.size() != whole_.size()) {
    throw std::runtime_error("the lens is for images of " + std::to_string(whole_.cols) + " x " +
                             std::to_string(whole_.rows) + " px, but this image has " +
                             std::to_string(image.cols) + " x " + std::to_string(image.rows));
  }
  cv::Mat warped;
  cv::remap(image, warped, whole_, fraction_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  return warped;
}

Lens ReadLens(const std::filesystem::path& file) {
  const StereoRig rig = ReadRig(file);
  if (rig.baseline() > 0) {
    throw std::runtime_error(
        file.string() + ": is for two cameras: expected the file of one camera (calibrate --left)");
  }
  return rig.left;
}

ImageFilter StraighteningOf(const Camera& camera) {
  if (camera.lens.empty()) return {};
  return [camera, warp = Read(camera)](const cv::Mat& image) {
    try {
      return warp.Apply(image);
    } catch (const std::runtime_error& error) {
      Refuse(camera, error);
    }
  };
}

}  // namespace palpate
