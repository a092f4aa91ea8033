// palpate-evaluate: the command line of `palpate-slave evaluate`, a program of its own for the sake
// of the Point Cloud Library, which costs every start 0.06 s and 37 MB.
#include "shared/program/command_line.h"
#include "shared/program/program.h"
#include "slave/commands/evaluate/evaluate.h"
#include "slave/commands/program.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --materials --out build/cube
  palpate-slave evaluate deploy/scenes/foam-cube.yaml --cloud cube.pcd --out build/cube)";

void AddOptions(CLI::App* command, EvaluateOptions* options) {
  command->add_option("scene", options->scene, "Scene file (YAML)")->required();
  command->add_option("--override", options->overrides,
                      "Replace a value: key.path=value (repeatable)");
  command->add_option("--cloud", options->cloud,
                      "Measured points in the frame of sense.depth_camera (PCD); without, a "
                      "simulated hand presses the object and a virtual camera measures it");
  command->add_option("--out", options->out, "Folder for report.html, report.json and clouds")
      ->required();
  command->add_option(
      "--contacts", options->contacts,
      "What deforms the object: CSV as for solve; without, what the scene's tactile "
      "recording tells at its end, or nothing");
  command->add_option("--loads", options->loads, "The same with forces");
  command
      ->add_option("--segment", options->segment,
                   "surfaces: by colour and shape; colour: by colour alone; no: all is the object")
      ->capture_default_str();
  command->add_option("--at", options->at, "A point on the object, x,y,z [m], frame of the cloud")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--colour", options->colour, "Colour of the object, red,green,blue")
      ->delimiter(',')
      ->expected(3);
  command->add_option("--voxel", options->voxel, "Cells of the cloud thinned out [m]; 0: by itself")
      ->capture_default_str();
  command->add_option("--neighbours", options->neighbours, "Of a point that grows by colour")
      ->capture_default_str();
  command->add_option("--point-colour", options->point_colour, "Within a region, 0 to 442")
      ->capture_default_str();
  command->add_option("--region-colour", options->region_colour, "Regions less different unite")
      ->capture_default_str();
  command->add_option("--repetitions", options->repetitions, "Presses of the simulated hand")
      ->capture_default_str();
  command->add_flag("--materials", options->materials,
                    "The simulated object in each of paper B's three foams");
  command->add_option("--leaf", options->leaf, "Edge of the octree's leaves [m]")
      ->capture_default_str();
}

int Main(int argc, char** argv) {
  LogToStderr();
  StopOnSignal stop;
  stop.ExpectAnswer();
  CLI::App app{"Score the estimated shape against a measured cloud", "palpate-slave evaluate"};
  app.footer(kExamples);
  app.set_version_flag("--version", Version());
  EvaluateOptions options;
  AddOptions(&app, &options);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : kUnusable;
  }
  return ExitCode([&] { return RunEvaluate(options, stop.token()); });
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::Main(argc, argv);
}
