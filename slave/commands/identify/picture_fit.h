// Young's modulus of a scene's object from recorded pictures of presses whose force was measured:
// the scene's sense tells its own force at a modulus, and by how much that is wrong.
#pragma once

#include <filesystem>
#include <stop_token>

#include "slave/scene/scene.h"

namespace palpate {

struct PictureFit {
  double young_modulus = 0, sigma_modulus = 0;  // [Pa]
  double prestress = 0;                         // the scene's; a dome's goes with the modulus [N/m]
  double offset = 0, sigma_offset = 0;          // of the measured forces [N]
  double rms = 0;                               // of the forces, over the largest [-]
  int samples = 0, pressed = 0;                 // with a force that is known and valid; not zero
  int passes = 0;                               // through the pictures
};

// `file`: a row a sample with `sequence`, from 1 (absent: row by row), and `force` or fx,fy,fz [N]:
// its size counts. Least squares of measured = s felt + offset over samples whose felt force is
// valid, again with s times the modulus until s is 1. Of a domed membrane tension goes with the
// modulus, which leaves the deflection's shape as it is. Throws InputError `file:line: ...`;
// std::invalid_argument: nothing is recorded; what MakeSensingPipeline throws; std::runtime_error:
// fewer than three valid presses, all of one force, no modulus found. Stopped: as far as it came.
PictureFit FitPictures(const Scene& scene, const std::filesystem::path& file,
                       const std::stop_token& stop);

}  // namespace palpate
