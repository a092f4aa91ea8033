// palpate-train: the command line of `palpate-slave train`.
#include "slave/commands/command_program.h"
#include "slave/commands/train/train.h"

namespace palpate {
namespace {

void AddOptions(CLI::App* command, TrainOptions* options) {
  command->add_option("DATA", options->data, "Recordings, or `simulated`; see below")->required();
  command->add_option(
      "--network", options->networks,
      "One or more of rnn_21 (default), rnn_19, dnn_21, dnn_19, tnn_21, tnn_19; or all "
      "(the first four)");
  Add(command, "--out", &options->out, "DIR", "Folder for network.json and training.csv")
      ->required();
  command->add_option("--test", options->test, "Test on these recordings, not on a fifth of DATA");
  Add(command, "--from", &options->from, "PATH",
      "Fit only the gain of this existing network, on the normal force fz");
  command->add_option("--finger", options->finger,
                      "Finger to use from a recording with several fingers");
  AddShown(command, "--rest", &options->rest,
           "Number of first samples, without contact, whose mean is the baseline");
  AddShown(command, "--optimiser", &options->optimiser, "adam, or sgd as in paper B");
  AddShown(command, "--rate", &options->training.rate,
           "Learning rate; 0 selects 0.004 for adam and 0.01 for sgd");
  AddShown(command, "--epochs", &options->training.epochs, "Largest number of epochs");
  AddShown(command, "--patience", &options->training.patience,
           "Stop after this many epochs without a lower validation error");
  AddShown(command, "--batch", &options->training.batch, "Windows per optimiser step");
  AddShown(command, "--seed", &options->seed, "Random seed; the same seed gives the same weights");
  AddShown(command, "--threads", &options->training.threads,
           "Number of threads; it does not change the result");
  AddShown(command, "--presses", &options->presses, "Number of contacts that `simulated` makes");
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  return palpate::RunCommandProgram(argc, argv, "train", palpate::kTrainHelp, palpate::AddOptions,
                                    palpate::RunTrain);
}
