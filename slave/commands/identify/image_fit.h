// Young's modulus of a scene's object from recorded images of contacts with a measured force. The
// estimated force at a modulus is compared with the measured one.
#pragma once

#include <filesystem>
#include <stop_token>

#include "slave/identify/identify_report.h"
#include "slave/scene/scene.h"

namespace palpate {

// `file` has one row per sample with `sequence`, from 1 (absent: row number), and `force` or
// fx,fy,fz [N]; the magnitude is used. Least squares of measured = s estimated + offset over
// samples with a valid estimate, repeated with s times the modulus until s is 1. For a domed
// membrane the tension is proportional to the modulus, which keeps the shape of the deflection.
// Throws InputError `file:line: ...`; std::invalid_argument: the scene has no recording; what
// MakeLiveSlave throws; std::runtime_error: fewer than three valid contacts, all of one
// force, or no modulus found. If stopped, returns the result so far.
ImageFit FitImages(const Scene& scene, const std::filesystem::path& file,
                   const std::stop_token& stop);

}  // namespace palpate
