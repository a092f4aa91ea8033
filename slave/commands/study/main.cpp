// palpate-study: the command line of `palpate-slave study`.
#include "slave/commands/command_program.h"
#include "slave/commands/study/study_command.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --end-to-end)";

void AddOptions(CLI::App* command, StudyOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  command->add_option("--out", options->out, "Folder for study.csv, study.json and study.svg")
      ->type_name("DIR")
      ->required();
  command->add_option("--budget", options->budget, "Time limit for all models together")
      ->type_name("FLOAT:s")
      ->capture_default_str();
  command->add_flag("--end-to-end", options->end_to_end,
                    "Measure instead what each stage adds to the error of the rendered force");
  command->add_option("--delay", options->delay, "Delay of the link for --end-to-end")
      ->type_name("FLOAT:s")
      ->capture_default_str();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  palpate::StudyOptions options;
  return palpate::RunCommandProgram(
      argc, argv, "study", palpate::kExamples,
      [&](CLI::App* command) { palpate::AddOptions(command, &options); },
      [&](const std::stop_token& stop) { return palpate::RunStudyCommand(options, stop); });
}
