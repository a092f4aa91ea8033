// `calibrate --register`: where the camera stands in the slave's frame, as lines for a scene.
#pragma once

#include <filesystem>

#include "slave/commands/calibrate/calibrate.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// `rig`: the cameras, nullptr: only the picture's size is known; `lens_file`: of the one camera,
// for the scene's `intrinsics`. The table goes to standard error, the lines to standard output and
// to `out` (empty: not). Returns the exit code; throws as RunCalibrate does.
int RunRegister(const CalibrateOptions& options, const StereoRig* rig,
                const std::filesystem::path& lens_file, const std::filesystem::path& out);

}  // namespace palpate
