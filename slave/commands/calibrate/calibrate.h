// `palpate-slave calibrate`: lenses and stereo rigs from images of a board, and the camera pose in
// the slave's frame.
#pragma once

#include <array>
#include <filesystem>
#include <stop_token>
#include <string>

namespace palpate {

struct CalibrateOptions {
  std::string left, right;           // globs as of a scene's camera; empty `right`: one camera
  std::array<int, 2> board{};        // inner corners: 9x6
  std::string square;                // edge of a square: 25mm
  std::filesystem::path out;         // the rig, the lens, or the scene's lines of a registration
  std::filesystem::path tip_places;  // CSV x,y,z,u,v[,u_right,v_right]: registers the camera
  std::filesystem::path rig;         // of --register
  std::array<int, 2> size{};         // registers a camera straight above the plane z = 0 [px]
  bool plane = false;                // the same with the lens of `rig`
};

// Returns the exit code: 0 done, 1 rejected (nothing is written). Throws
// std::invalid_argument: unusable options or data; std::runtime_error: the command failed.
int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop);

// The part --register of RunCalibrate. The table is written to standard error, the scene's lines to
// standard output and to --out.
int RunRegister(const CalibrateOptions& options);

}  // namespace palpate
