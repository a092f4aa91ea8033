// palpate-train: the command line of `palpate-slave train`.
#include "slave/commands/command_program.h"
#include "slave/simulator/presses/train.h"

namespace palpate {
namespace {

void AddOptions(CLI::App* command, TrainOptions* options) {
  command->add_option("DATA", options->data, "simulated")->required();
  Add(command, "--out", &options->out, "DIR", "Folder for the CSV files, one per start")
      ->required();
  AddShown(command, "--presses", &options->presses, "Number of contacts");
  AddShown(command, "--seed", &options->seed, "Random seed; the same seed gives the same contacts");
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "train", palpate::kTrainHelp, palpate::AddOptions,
                                    palpate::RunTrain);
}
