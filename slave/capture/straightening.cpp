#include "slave/capture/straightening.h"

#include <stdexcept>

namespace palpate {
namespace {

[[noreturn]] void Refuse(const Camera& camera, const std::exception& error) {
  throw std::runtime_error("sense.camera.intrinsics = " + camera.lens.string() + ": " +
                           error.what());
}

}  // namespace

std::optional<LensWarp> StraighteningOf(const Camera& camera) {
  if (camera.lens.empty()) return std::nullopt;
  try {
    return LensWarp::Straightening(ReadLens(camera.lens));
  } catch (const std::runtime_error& error) {
    Refuse(camera, error);
  }
}

cv::Mat Straightened(const Camera& camera, const std::optional<LensWarp>& warp,
                     const cv::Mat& picture) {
  if (!warp || picture.empty()) return picture;
  try {
    return warp->Apply(picture);
  } catch (const std::runtime_error& error) {
    Refuse(camera, error);
  }
}

}  // namespace palpate
