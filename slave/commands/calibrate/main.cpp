// palpate-calibrate: the command line of `palpate-slave calibrate`, a program of its own because
// OpenCV's calib3d needs 230 packages at build time.
#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "slave/commands/calibrate/calibrate.h"
#include "slave/commands/program.h"

namespace palpate {
namespace {

void AddOptions(CLI::App* command, CalibrateOptions* calibrate) {
  command->add_option("--left", calibrate->left,
                      "Images of the left, or the only, camera: a pattern in quotes");
  command->add_option("--right", calibrate->right,
                      "Images of the right camera: a pattern in quotes");
  command->add_option("--board", calibrate->board,
                      "Inner corners, or circles, of the board, for example 9x6");
  command->add_option("--square", calibrate->square,
                      "Distance between neighbouring corners or circles, for example 25mm");
  command
      ->add_option("--pattern", calibrate->pattern,
                   "Pattern of the board: chessboard, circles or asymmetric-circles")
      ->capture_default_str();
  command->add_option("--distance", calibrate->distance,
                      "Distance of a plane, for example 250mm; prints the size of a pixel on it");
  command->add_option("--out", calibrate->out, "File for the rig, or for the lens of one camera")
      ->type_name("FILE");
  command
      ->add_option("--drawing", calibrate->drawing,
                   "SVG file that shows boards, coverage and residuals")
      ->type_name("FILE");
  command->add_flag("--force", calibrate->force,
                    "Write a calibration even if it is rejected; the exit code stays 1");
  command
      ->add_option("--register", calibrate->tip_places,
                   "Estimate the camera pose from tip positions: CSV x,y,z,u,v[,u_right,v_right]")
      ->type_name("FILE");
  command->add_option("--rig", calibrate->rig, "For --register: an existing rig or lens file")
      ->type_name("FILE");
  command->add_option("--size", calibrate->size,
                      "For --register: image size of a camera that looks straight down on z = 0, "
                      "for example 640x480");
  command->add_option("unquoted", calibrate->unquoted)->group("");
  command->add_flag("--plane", calibrate->plane,
                    "For --register: the calibrated camera looks straight down on z = 0");
}

int Main(int argc, char** argv) {
  LogToStderr();
  StopOnSignal stop;
  stop.ExpectAnswer();
  CLI::App app{"Calibrate lens, stereo rig and pose of cameras from images of a board",
               "palpate-slave calibrate"};
  app.footer(kCalibrateHelp);
  app.set_version_flag("--version", Version());
  CalibrateOptions options;
  AddOptions(&app, &options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kUnusable;
  }
  return ExitCode([&] { return RunCalibrate(options, stop.token()); });
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
