// palpate-calibrate: the command line of `palpate-slave calibrate`, a program of its own because
// OpenCV's calib3d needs 230 packages at build time.
#include "slave/commands/calibrate/calibrate.h"
#include "slave/commands/command_program.h"

namespace palpate {
namespace {

void AddOptions(CLI::App* command, CalibrateOptions* options) {
  command->add_option("--left", options->left,
                      "Images of the left, or the only, camera: a pattern in quotes");
  command->add_option("--right", options->right, "Images of the right camera: a pattern in quotes");
  command->add_option("--board", options->board,
                      "Inner corners, or circles, of the board, for example 9x6");
  command->add_option("--square", options->square,
                      "Distance between neighbouring corners or circles, for example 25mm");
  AddShown(command, "--pattern", &options->pattern,
           "Pattern of the board: chessboard, circles or asymmetric-circles");
  command->add_option("--distance", options->distance,
                      "Distance of a plane, for example 250mm; prints the size of a pixel on it");
  Add(command, "--out", &options->out, "FILE", "File for the rig, or for the lens of one camera");
  Add(command, "--corners", &options->corners, "FILE",
      "Also write the corners in the last image of --left, row after row: CSV u,v");
  command->add_flag("--force", options->force,
                    "Write a calibration even if it is rejected; the exit code stays 1");
  Add(command, "--register", &options->tip_places, "FILE",
      "Estimate the camera pose from tip positions: CSV x,y,z,u,v[,u_right,v_right]");
  Add(command, "--rig", &options->rig, "FILE", "For --register: an existing rig or lens file");
  command->add_option("--size", options->size,
                      "For --register: image size of a camera that looks straight down on z = 0, "
                      "for example 640x480");
  command->add_option("unquoted", options->unquoted)->group("");
  command->add_flag("--plane", options->plane,
                    "For --register: the calibrated camera looks straight down on z = 0");
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "calibrate", palpate::kCalibrateHelp,
                                    palpate::AddOptions, palpate::RunCalibrate);
}
