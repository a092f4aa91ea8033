// Pictures of a camera whose lens the scene names come straight to everybody who looks at them.
#pragma once

#include <optional>

#include "shared/scene/scene.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {

// nullopt: the scene names no lens. Throws std::runtime_error naming sense.camera.intrinsics: its
// file is unreadable, no lens, or of two cameras.
std::optional<LensWarp> StraighteningOf(const Camera& camera);

// The picture, straightened if there is a lens. Throws std::runtime_error naming
// sense.camera.intrinsics where the picture has another size than the lens.
cv::Mat Straightened(const Camera& camera, const std::optional<LensWarp>& warp,
                     const cv::Mat& picture);

}  // namespace palpate
