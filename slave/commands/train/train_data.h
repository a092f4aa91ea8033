// What the command line of `train` names, read.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "slave/commands/train/train.h"
#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

struct TrainingData {
  std::vector<LabelledRecording> data;
  std::vector<LabelledRecording> test;  // empty: set a part of `data` aside
};

// Throws std::invalid_argument with the file, and the line where there is one. Overlaps of test and
// data are warned of on standard error.
TrainingData ReadTrainingData(const TrainOptions& options);

// Throws std::invalid_argument: two of them contain the same samples, which would count twice.
void RefuseRepetitions(std::span<const std::string> data);

// Throws std::invalid_argument: `network` takes `inputs` signals and a recording lacks a column of
// them.
void RequireSignals(const TrainingData& data, const std::string& network, int inputs);

// `a.csv, b.csv+w.csv@0:9.5`, without the folders.
std::string NamesOf(std::span<const std::string> data);

}  // namespace palpate
