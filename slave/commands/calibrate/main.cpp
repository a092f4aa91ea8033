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
  command
      ->add_option("--pattern", options->pattern,
                   "Pattern of the board: chessboard, circles or asymmetric-circles")
      ->capture_default_str();
  command->add_option("--distance", options->distance,
                      "Distance of a plane, for example 250mm; prints the size of a pixel on it");
  command->add_option("--out", options->out, "File for the rig, or for the lens of one camera")
      ->type_name("FILE");
  command
      ->add_option("--drawing", options->drawing,
                   "SVG file that shows boards, coverage and residuals")
      ->type_name("FILE");
  command->add_flag("--force", options->force,
                    "Write a calibration even if it is rejected; the exit code stays 1");
  command
      ->add_option("--register", options->tip_places,
                   "Estimate the camera pose from tip positions: CSV x,y,z,u,v[,u_right,v_right]")
      ->type_name("FILE");
  command->add_option("--rig", options->rig, "For --register: an existing rig or lens file")
      ->type_name("FILE");
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
  palpate::CalibrateOptions options;
  return palpate::RunCommandProgram(
      argc, argv, "calibrate", palpate::kCalibrateHelp,
      [&](CLI::App* command) { palpate::AddOptions(command, &options); },
      [&](const std::stop_token& stop) { return palpate::RunCalibrate(options, stop); });
}
