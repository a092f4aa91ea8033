// The command line of `palpate-slave calibrate`.
#include "slave/commands/calibrate/calibrate.h"
#include "slave/commands/command_program.h"
#include "slave/commands/tools.h"

namespace palpate {
namespace {

constexpr const char* kCalibrateHelp = R"(Examples:
  palpate-slave calibrate --left 'left*.jpg' --right 'right*.jpg' --board 9x6 --square 25mm \
      --out rig.yaml
  palpate-slave calibrate --left 'board*.png' --board 9x6 --square 2.5mm --out lens.yaml
  palpate-slave calibrate --register tips.csv --rig rig.yaml --out pose.yaml
  palpate-slave calibrate --register tips.csv --rig lens.yaml --plane
  palpate-slave calibrate --register tips.csv --size 640x480

Take ten to twenty images of a chessboard, tilted to all sides by 20 to 40 degrees, near and far, in
every corner of the image. The last number in their names pairs left and right.

--register reads rows of the tip position in S [m] and in the image [px], and prints the lines for
the scene's sense.camera.

A result that may be wrong is rejected with the reason and exit code 1. The guides of one camera and
of two cameras list the reasons.)";

void AddCalibrateOptions(CLI::App* command, CalibrateOptions* options) {
  auto* left = command->add_option("--left", options->left,
                                   "Images of the left, or the only, camera: a pattern in quotes");
  command->add_option("--right", options->right, "Images of the right camera: a pattern in quotes")
      ->needs(left);
  left->needs(command
                  ->add_option("--board", options->board,
                               "Inner corners of the chessboard, for example 9x6")
                  ->type_name("NxN")
                  ->delimiter('x')
                  ->check(CLI::Range(3, 100).description("")));
  left->needs(
      command->add_option("--square", options->square, "Edge of a square, for example 25mm"));
  left->needs(Add(command, "--out", &options->out, "FILE",
                  "File for the rig, for the lens of one camera, or for the lines of --register"));
  auto* tips = Add(command, "--register", &options->tip_places, "FILE",
                   "Estimate the camera pose from tip positions: CSV x,y,z,u,v[,u_right,v_right]");
  auto* rig = Add(command, "--rig", &options->rig, "FILE",
                  "For --register: a rig, or with --plane a lens file");
  tips->excludes(left);
  rig->needs(tips);
  command
      ->add_option("--size", options->size,
                   "For --register: image size of a camera that looks straight down on z = 0, "
                   "for example 640x480")
      ->type_name("NxN")
      ->delimiter('x')
      ->check(CLI::Range(1, 100000).description(""))
      ->needs(tips)
      ->excludes(rig);
  command
      ->add_flag("--plane", options->plane,
                 "For --register: the calibrated camera looks straight down on z = 0")
      ->needs(rig);
}

}  // namespace

int CalibrateMain(int argc, char** argv) {
  return RunCommandProgram(argc, argv, "calibrate", kCalibrateHelp, AddCalibrateOptions,
                           RunCalibrate);
}

}  // namespace palpate
