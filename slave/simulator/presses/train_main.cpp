// The command line of `palpate-slave train`.
#include "slave/commands/command_program.h"
#include "slave/commands/tools.h"
#include "slave/simulator/presses/train.h"

namespace palpate {
namespace {

void AddTrainOptions(CLI::App* command, TrainOptions* options) {
  command->add_option("DATA", options->data, "simulated")->required();
  Add(command, "--out", &options->out, "DIR", "Folder for the CSV files, one per start")
      ->required();
  AddShown(command, "--presses", &options->presses, "Number of contacts");
  AddShown(command, "--seed", &options->seed, "Random seed; the same seed gives the same contacts");
}

}  // namespace

int TrainMain(int argc, char** argv) {
  return RunCommandProgram(argc, argv, "train", kTrainHelp, AddTrainOptions, RunTrain);
}

}  // namespace palpate
