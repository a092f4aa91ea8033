#include "slave/vision/stereo/straightening.h"

#include <stdexcept>

#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

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

PictureFilter StraighteningOf(const Camera& camera) {
  if (camera.lens.empty()) return {};
  return [camera, warp = Read(camera)](const cv::Mat& picture) {
    try {
      return warp.Apply(picture);
    } catch (const std::runtime_error& error) {
      Refuse(camera, error);
    }
  };
}

}  // namespace palpate
