// palpate-calibrate: the command line of `palpate-slave calibrate`, a program of its own for the
// sake of OpenCV's calib3d, which brings 230 packages to whoever compiles it.
#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "slave/commands/calibrate/calibrate.h"
#include "slave/commands/program.h"

namespace palpate {
namespace {

void AddOptions(CLI::App* command, CalibrateOptions* calibrate) {
  command->add_option("--left", calibrate->left, "Pictures of the left, or the only, camera");
  command->add_option("--right", calibrate->right, "Pictures of the right camera");
  command->add_option("--board", calibrate->board, "Inner corners or circles, 9x6 say");
  command->add_option("--square", calibrate->square, "Between neighbours, 25mm say");
  command->add_option("--pattern", calibrate->pattern, "chessboard, circles or asymmetric-circles")
      ->capture_default_str();
  command->add_option("--distance", calibrate->distance,
                      "Of a plane, 250mm say: prints what a pixel shows there");
  command->add_option("--out", calibrate->out, "File of the rig, or of the lens of one camera");
  command->add_option("--drawing", calibrate->drawing, "SVG of boards, coverage and residuals");
  command->add_flag("--force", calibrate->force,
                    "Write also what cannot be trusted; still exits 1");
  command->add_option("--register", calibrate->tip_places,
                      "CSV x,y,z,u,v[,u_right,v_right] of the tip: the camera's pose for a scene");
  command->add_option("--rig", calibrate->rig, "For --register: a rig or lens known already");
  command->add_option("--size", calibrate->size,
                      "For --register: a camera straight above z = 0, 640x480 say");
  command->add_option("unquoted", calibrate->unquoted)->group("");
  command->add_flag("--plane", calibrate->plane,
                    "For --register: the camera of the lens looks straight down on z = 0");
}

int Main(int argc, char** argv) {
  LogToStderr();
  StopOnSignal stop;
  stop.ExpectAnswer();
  CLI::App app{"Lens, rig and pose of cameras, from pictures of a board",
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
