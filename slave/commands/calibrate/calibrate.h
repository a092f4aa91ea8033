// `palpate-slave calibrate`: lenses and stereo rigs from images of a board, and the camera pose in
// the slave's frame.
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/vision/stereo/rig.h"

namespace palpate {

struct CalibrateOptions {
  std::string left, right;             // globs as of a scene's camera; empty `right`: one camera
  std::string board;                   // inner corners, or circles: 9x6
  std::string square;                  // between neighbours: 25mm
  std::string pattern = "chessboard";  // circles, asymmetric-circles
  std::string distance;                // distance of a plane whose pixel size is printed: 250mm
  // File of the rig or lens; for a registration alone: file of the scene's lines.
  std::filesystem::path out;
  std::filesystem::path corners;      // CSV u,v of the board in the last image; empty: none
  bool force = false;                 // write a rejected calibration too
  std::filesystem::path tip_places;   // CSV x,y,z,u,v[,u_right,v_right]: registers the camera
  std::filesystem::path rig;          // image size for the registration without a board
  std::string size;                   // 640x480: registers a camera straight above the plane z = 0
  bool plane = false;                 // calibrates the plane with a known lens
  std::vector<std::string> unquoted;  // file names that a shell made from an unquoted glob
};

inline constexpr const char* kCalibrateHelp = R"(Examples:
  palpate-slave calibrate --left 'left*.jpg' --right 'right*.jpg' --board 9x6 --square 25mm \
      --out rig.yaml
  palpate-slave calibrate --left 'board*.png' --board 9x6 --square 2.5mm --out lens.yaml \
      --distance 250mm
  palpate-slave calibrate --left 'grid*.png' --pattern asymmetric-circles --board 4x11 \
      --square 10mm --out lens.yaml
  palpate-slave calibrate --register tips.csv --rig rig.yaml --out pose.yaml
  palpate-slave calibrate --register tips.csv --rig lens.yaml --plane
  palpate-slave calibrate --register tips.csv --size 640x480

Take ten to twenty images of the board, tilted to all sides by 20 to 40 degrees, near and far, in
every corner of the image. Images of a stereo pair must be taken at the same instant. The last
number in their names pairs left and right. For asymmetric circles --square is the distance of two
rows.

Images without the board, unreadable images and pairs that contradict the others are listed and not
used. Exchanged sides are reported and corrected. A calibration that may be wrong is rejected with
the reason and exit code 1, and written only with --force.

--register reads rows of the tip position in S [m] and in the image [px]. With u_right,v_right and a
rig the positions are triangulated. With one lens the camera pose is fitted. With --plane, or with
--size and no lens, pixel size and pose are fitted for a camera that looks straight down on z = 0.
The lines for the scene's sense.camera go to standard output. A pose is rejected in the same way.

The guides of one camera and of two cameras list the reasons of a rejection.)";

// Returns the exit code: 0 done, 1 rejected (nothing is written without `force`). Throws
// std::invalid_argument: unusable options or data; std::runtime_error: the command failed.
int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop);

// Two positive counts `9x6`. Throws std::invalid_argument naming the option.
std::array<int, 2> TwoCounts(const std::string& option, const std::string& text, int least,
                             int most, const char* example);

// The part --register of RunCalibrate. `rig`: the cameras; nullptr: only the image's size is known.
// `lens_file`: the lens of a single camera, for the scene's `intrinsics`. The table is written to
// standard error, the scene's lines to standard output and to `out` (empty: no file).
int RunRegister(const CalibrateOptions& options, const StereoRig* rig,
                const std::filesystem::path& lens_file, const std::filesystem::path& out);

}  // namespace palpate
