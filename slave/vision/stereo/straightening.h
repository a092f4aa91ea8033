// Pictures of a camera whose lens the scene names come straight to everybody who looks at them.
#pragma once

#include "slave/capture/frame_source.h"
#include "slave/scene/scene.h"

namespace palpate {

// What straightens the camera's pictures; empty: the scene names no lens. Throws
// std::runtime_error naming sense.camera.intrinsics: its file is unreadable, no lens, or of two
// cameras; the filter throws it where a picture has another size than the lens.
PictureFilter StraighteningOf(const Camera& camera);

}  // namespace palpate
