// palpate-study: the command line of `palpate-slave study`.
#include "slave/commands/command_program.h"
#include "slave/commands/study/study_command.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60)";

void AddOptions(CLI::App* command, StudyOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  Add(command, "--out", &options->out, "DIR", "Folder for study.csv and study.json");
  Add(command, "--budget", &options->budget, "FLOAT:s", "Time limit for all models together")
      ->capture_default_str();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "study", palpate::kExamples, palpate::AddOptions,
                                    palpate::RunStudyCommand);
}
