// palpate-study: the command line of `palpate-slave study`.
#include "slave/commands/command_program.h"
#include "slave/commands/study/study_command.h"

namespace palpate {
namespace {

constexpr const char* kExamples = R"(Examples:
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --budget 60
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/study --end-to-end
  palpate-slave study deploy/scenes/silicone-block.yaml --out build/shards --shard 3/8
  palpate-slave study deploy/scenes/silicone-block.yaml --merge build/shards)";

void AddOptions(CLI::App* command, StudyOptions* options) {
  AddSceneOptions(command, &options->scene, &options->overrides);
  Add(command, "--out", &options->out, "DIR",
      "Folder for study.csv, study.json and study.svg, or for the file of --shard");
  CLI::Option* budget = Add(command, "--budget", &options->budget, "FLOAT:s",
                            "Time limit for all models together, or for those of the shard")
                            ->capture_default_str();
  CLI::Option* shard = Add(command, "--shard", &options->shard, "I/N",
                           "Measure only part I of N of the models; run again, it continues");
  CLI::Option* merge =
      Add(command, "--merge", &options->merge, "DIR",
          "Make the study of all parts in DIR, with the same scene and overrides; --out is DIR")
          ->excludes(shard)
          ->excludes(budget);
  command
      ->add_flag("--end-to-end", options->end_to_end,
                 "Measure instead what each stage adds to the error of the rendered force")
      ->excludes(shard)
      ->excludes(merge);
  Add(command, "--delay", &options->delay, "FLOAT:s", "Delay of the link for --end-to-end")
      ->capture_default_str();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "study", palpate::kExamples, palpate::AddOptions,
                                    palpate::RunStudyCommand);
}
