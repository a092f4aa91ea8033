// palpate-precompute: the command line of `palpate-slave precompute`.
#include "slave/commands/command_program.h"
#include "slave/commands/precompute/precompute_command.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave precompute organ.yaml
  palpate-slave precompute organ.yaml --shard 3/8
  palpate-slave precompute organ.yaml --shard 3/8 --override model.cache=/shared/green)";

void AddOptions(CLI::App* command, PrecomputeOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  Add(command, "--shard", &options->shard, "I/N",
      "Compute only part I of N of the columns; run again, it continues")
      ->capture_default_str();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "precompute", palpate::kExamples,
                                    palpate::AddOptions, palpate::RunPrecompute);
}
