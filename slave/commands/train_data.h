// What the command line of `train` names, read.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "slave/commands/train.h"
#include "slave/tactile/training/labelled_recording.h"

namespace palpate {

struct TrainingData {
  std::vector<LabelledRecording> data;
  std::vector<LabelledRecording> test;  // empty: set a part of `data` aside
};

// Throws std::invalid_argument with the file, and the line where there is one. Overlaps of test and
// data are warned of on standard error.
TrainingData ReadTrainingData(const TrainOptions& options);

// `a.csv, b.csv+w.csv@0:9.5`, without the folders.
std::string NamesOf(std::span<const std::string> data);

}  // namespace palpate
