// `palpate-slave calibrate`: lenses and rigs from pictures of a board, and where the camera stands
// in the slave's frame (contracts).
#pragma once

#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

namespace palpate {

struct CalibrateOptions {
  std::string left, right;             // globs as of a scene's camera; empty `right`: one camera
  std::string board;                   // inner corners, or circles: 9x6
  std::string square;                  // between neighbours: 25mm
  std::string pattern = "chessboard";  // circles, asymmetric-circles
  std::string distance;                // of a plane whose pixel size is asked for: 250mm
  std::filesystem::path out;           // rig or lens; of a registration alone: the scene's lines
  std::filesystem::path drawing;       // SVG; empty: none
  bool force = false;                  // write what cannot be trusted
  std::filesystem::path tip_places;    // CSV x,y,z,u,v[,u_right,v_right]: registers the camera
  std::filesystem::path rig;           // for the registration, where no board is given
  std::string size;                    // 640x480: registers a camera straight above the plane z = 0
  bool plane = false;                  // the same with the lens known
  std::vector<std::string> unquoted;   // names that a shell made of a glob without quotes
};

inline constexpr const char* kCalibrateHelp = R"(Examples:
  palpate-slave calibrate --left 'left*.jpg' --right 'right*.jpg' --board 9x6 --square 25mm \
      --out rig.yaml --drawing rig.svg
  palpate-slave calibrate --left 'board*.png' --board 9x6 --square 2.5mm --out lens.yaml \
      --distance 250mm
  palpate-slave calibrate --left 'grid*.png' --pattern asymmetric-circles --board 4x11 \
      --square 10mm --out lens.yaml
  palpate-slave calibrate --register tips.csv --rig rig.yaml --out pose.yaml
  palpate-slave calibrate --register tips.csv --rig lens.yaml --plane
  palpate-slave calibrate --register tips.csv --size 640x480

The board: ten to twenty pictures (pairs at the same instant), tilted to all sides by 20 to 40
degrees, near and far, in every corner of the picture. Left and right belong together by the last
number in their names. --square of asymmetric circles is the distance of two rows.

Pictures without the board, unreadable ones and pairs that contradict the others are named and left
out; exchanged sides are named and put right. What cannot be trusted is said with the reason, exits
1 and is written with --force only: halves of the pictures must repeat the baseline (one camera: the
focal length) to 1 % (one sigma), corners be off by 1 px rms at most and lie in 15 % of the picture.

--register: rows of the tip's place in S [m] and in the picture [px]. With u_right,v_right and a
pair the places are triangulated; with one lens its pose is fitted, or with --plane, or --size and
no lens at all, pixel size and pose of a camera that looks straight down on z = 0. The lines for the
scene's sense.camera go to standard output.)";

// Returns the exit code: 0 done, 1 not to be trusted (nothing is written without `force`). Throws
// std::invalid_argument: what is unusable; std::runtime_error: ran and failed.
int RunCalibrate(const CalibrateOptions& options, const std::stop_token& stop);

}  // namespace palpate
