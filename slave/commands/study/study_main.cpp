// The command line of `palpate-slave study`.
#include "slave/commands/command_program.h"
#include "slave/commands/study/study_command.h"
#include "slave/commands/tools.h"

namespace palpate {
namespace {

constexpr const char* kStudyExamples = R"(Examples:
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60)";

void AddStudyOptions(CLI::App* command, StudyOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  Add(command, "--out", &options->out, "DIR", "Folder for study.csv and study.json");
  Add(command, "--budget", &options->budget, "FLOAT:s", "Time limit for all models together")
      ->capture_default_str();
}

}  // namespace

int StudyMain(int argc, char** argv) {
  return RunCommandProgram(argc, argv, "study", kStudyExamples, AddStudyOptions, RunStudyCommand);
}

}  // namespace palpate
