// The command line of `palpate-slave precompute`.
#include "slave/commands/command_program.h"
#include "slave/commands/precompute/precompute_command.h"
#include "slave/commands/tools.h"

namespace palpate {
namespace {

constexpr const char* kPrecomputeExamples = R"(Examples:
  palpate-slave precompute organ.yaml
  palpate-slave precompute organ.yaml --shard 3/8
  palpate-slave precompute organ.yaml --shard 3/8 --override model.cache=/shared/green)";

void AddPrecomputeOptions(CLI::App* command, PrecomputeOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  Add(command, "--shard", &options->shard, "I/N",
      "Compute only part I of N of the columns; run again, it continues")
      ->capture_default_str();
}

}  // namespace

int PrecomputeMain(int argc, char** argv) {
  return RunCommandProgram(argc, argv, "precompute", kPrecomputeExamples, AddPrecomputeOptions,
                           RunPrecompute);
}

}  // namespace palpate
