// The command line of `palpate-slave precompute`.
#include "slave/commands/command_program.h"
#include "slave/commands/precompute/precompute_command.h"
#include "slave/commands/tools.h"

namespace palpate {
namespace {

constexpr const char* kPrecomputeExamples = R"(Examples:
  palpate-slave precompute organ.yaml
  palpate-slave precompute organ.yaml --override model.cache=/shared/green)";

void AddPrecomputeOptions(CLI::App* command, PrecomputeOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
}

}  // namespace

int PrecomputeMain(int argc, char** argv) {
  return RunCommandProgram(argc, argv, "precompute", kPrecomputeExamples, AddPrecomputeOptions,
                           RunPrecompute);
}

}  // namespace palpate
