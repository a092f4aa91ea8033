// Parts of `train`: reads the inputs of the command line, trains the networks, prints and writes
// the results.
#pragma once

#include <filesystem>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/commands/train/train.h"
#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/training/estimate_errors.h"
#include "slave/tactile/training/force_trainer.h"

namespace palpate {

struct TrainingData {
  std::vector<LabelledRecording> data;
  std::vector<LabelledRecording> test;  // empty: set a part of `data` aside
};

// Throws std::invalid_argument with the file, and the line if there is one. Overlaps of test and
// training data give a warning on standard error.
TrainingData ReadTrainingData(const TrainOptions& options);

// Throws std::invalid_argument: two of them contain the same samples, which would count twice.
void RefuseRepetitions(std::span<const std::string> data);

// Throws std::invalid_argument: `network` needs `inputs` signals and a recording lacks one of these
// columns.
void RequireSignals(const TrainingData& data, const std::string& network, int inputs);

// `a.csv, b.csv+w.csv@0:9.5`, without the folders.
std::string NamesOf(std::span<const std::string> data);

// Trains force networks. As RunTrain. Several networks are written to folders with their names.
int TrainForceNetworks(const TrainOptions& options, const std::stop_token& stop);

// Fits the gain of the known network options.from. As RunTrain.
int TrainForceGain(const TrainOptions& options);

struct TestedNetwork {
  std::string architecture;
  ForceErrors errors;
};
// The paper's table I: RMSE in mN and SMSE per axis.
std::string ForceTable(std::span<const TestedNetwork> networks);

// Root mean square error, correlation and the error at the peak of fz, as one line.
std::string AlongNormal(const ForceErrors& errors);

// epoch,loss,validation_loss. Throws std::runtime_error naming the file.
void WriteEpochs(const std::filesystem::path& file, std::span<const TrainingEpoch> epochs);

// Creates `dir` if missing and tries to write there. Throws std::runtime_error naming it.
void MakeWritable(const std::filesystem::path& dir);

}  // namespace palpate
