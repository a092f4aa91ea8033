// palpate-train: the command line of `palpate-slave train`.
#include "slave/commands/command_program.h"
#include "slave/commands/train/train.h"

namespace palpate {
namespace {

void AddOptions(CLI::App* command, TrainOptions* options) {
  command->add_option("DATA", options->data, "Recordings, or `simulated`; see below")->required();
  command->add_option(
      "--network", options->networks,
      "One or more of rnn_21 (default), rnn_19, dnn_21, dnn_19, tnn_21, tnn_19; all "
      "(the first four); or localiser");
  command->add_option("--out", options->out, "Folder for network.json and training.csv")
      ->type_name("DIR")
      ->required();
  command->add_option("--test", options->test, "Test on these recordings, not on a fifth of DATA");
  command
      ->add_option("--from", options->from,
                   "Fit only the gain of this existing network, on the normal force fz")
      ->type_name("PATH");
  command->add_option("--finger", options->finger,
                      "Finger to use from a recording with several fingers");
  command
      ->add_option("--rest", options->rest,
                   "Number of first samples, without contact, whose mean is the baseline")
      ->capture_default_str();
  command->add_option("--optimiser", options->optimiser, "adam, or sgd as in paper B")
      ->capture_default_str();
  command
      ->add_option("--rate", options->training.rate,
                   "Learning rate; 0 selects 0.004 for adam and 0.01 for sgd")
      ->capture_default_str();
  command->add_option("--epochs", options->training.epochs, "Largest number of epochs")
      ->capture_default_str();
  command
      ->add_option("--patience", options->training.patience,
                   "Stop after this many epochs without a lower validation error")
      ->capture_default_str();
  command->add_option("--batch", options->training.batch, "Windows per optimiser step")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Random seed; the same seed gives the same weights")
      ->capture_default_str();
  command
      ->add_option("--threads", options->training.threads,
                   "Number of threads; it does not change the result")
      ->capture_default_str();
  command->add_option("--presses", options->presses, "Number of contacts that `simulated` makes")
      ->capture_default_str();
  command
      ->add_option("--electrodes", options->electrodes,
                   "Required for localiser: file with rows NAME,x,y,z,nx,ny,nz in mm, or simulated")
      ->type_name("FILE");
  command->add_option("--contact-pdc", options->contact_pdc,
                      "For localiser: pressure pdc above which a sample is in contact [counts]; "
                      "default: estimated from the data");
  command
      ->add_option("--normals", options->normals,
                   "For localiser: axes of nx,ny,nz in the fingertip frame, for example -x,y,-z; "
                   "auto estimates them")
      ->capture_default_str();
}

}  // namespace
}  // namespace palpate

int main(int argc, char** argv) {
  palpate::TrainOptions options;
  return palpate::RunCommandProgram(
      argc, argv, "train", palpate::kTrainHelp,
      [&](CLI::App* command) { palpate::AddOptions(command, &options); },
      [&](const std::stop_token& stop) { return palpate::RunTrain(options, stop); });
}
