// palpate-evaluate: the command line of `palpate-slave evaluate`, a separate program, because
// loading the Point Cloud Library takes 0.06 s and 37 MB.
#include "slave/commands/command_program.h"
#include "slave/commands/evaluate/evaluate.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --cloud cube.pcd --out build/cube)";

void AddOptions(CLI::App* command, EvaluateOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  Add(command, "--cloud", &options->cloud, "FILE",
      "Measured points (PCD) in the frame of sense.depth_camera")
      ->required();
  Add(command, "--out", &options->out, "DIR", "Folder for report.json and clouds")->required();
  Add(command, "--contacts", &options->contacts, "FILE",
      "Contacts that deform the object: CSV as for solve; default: the end of the "
      "scene's tactile recording, if any");
  Add(command, "--loads", &options->loads, "FILE",
      "Loads that deform the object: CSV as for solve");
  AddShown(command, "--segment", &options->segment,
           "surfaces: segment by colour and shape; colour: by colour alone; no: every point "
           "belongs to the object");
  command
      ->add_option("--at", options->at,
                   "A point on the object in the frame of the cloud: x,y,z [m]")
      ->delimiter(',')
      ->expected(3);
  AddShown(command, "--leaf", &options->leaf, "Edge of the octree's leaves [m]");
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "evaluate", palpate::kExamples, palpate::AddOptions,
                                    palpate::RunEvaluate);
}
