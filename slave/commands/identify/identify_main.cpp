// The command line of `palpate-slave identify`.
#include "slave/commands/command_program.h"
#include "slave/commands/identify/identify.h"
#include "slave/commands/tools.h"

namespace palpate {
namespace {

void AddIdentifyOptions(CLI::App* command, IdentifyOptions* options) {
  command->add_option("DATA", options->data, "Tables of tests; see below")->required();
  command->add_option("--out", options->out, "Folder for report.json")
      ->type_name("DIR")
      ->required();
  command->add_option("--diameter", options->diameter,
                      "Diameter of a cylindrical specimen, for example 50mm");
  command->add_option("--area", options->area,
                      "Area of the loaded cross-section, for example 400mm2");
  command->add_option("--height", options->height,
                      "Height of the specimen at rest, or its gauge length");
  command
      ->add_option("--ends", options->ends,
                   "free, or bonded for a cylinder whose ends adhere to plates")
      ->capture_default_str();
  command->add_option("--poisson", options->poisson_ratio, "Poisson's ratio, used for bonded ends")
      ->check(CLI::Range(-0.9, 0.5))
      ->capture_default_str();
  command->add_option("--stress-unit", options->stress_unit,
                      "Unit of stress columns whose header names none; default: Pa");
  command->add_option("--x", options->x, "Name of the deformation column");
  command->add_option("--y", options->y, "Name of the load column");
  command->add_option("--from", options->from, "Use rows whose absolute strain is at least this");
  command->add_option("--to", options->to, "Use rows whose absolute strain is at most this");
  command->add_option("--scene", options->scene, "For press, loads and images: scene file (YAML)")
      ->type_name("FILE");
  command->add_option("--override", options->overrides,
                      "For press, loads and images: replace a value of the scene, key.path=value");
  command
      ->add_option("--width", options->width,
                   "For press and loads: contact width of rows without one [m]")
      ->check(CLI::Range(0.0, 1e3));
  command->add_flag("--fit-poisson", options->fit_poisson,
                    "For press: estimate Poisson's ratio as well");
}

}  // namespace

int IdentifyMain(int argc, char** argv) {
  return RunCommandProgram(argc, argv, "identify", kIdentifyHelp, AddIdentifyOptions, RunIdentify);
}

}  // namespace palpate
