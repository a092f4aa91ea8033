// `palpate-slave train`: networks that turn a fingertip's signals into force, and one gain that
// fits a known network to another fingertip.
#pragma once

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>
#include <vector>

#include "slave/tactile/training/force_trainer.h"

namespace palpate {

struct TrainOptions {
  std::vector<std::string> data;      // see DataArgument; or `simulated`
  std::vector<std::string> test;      // the same; empty: a fifth of the data
  std::vector<std::string> networks;  // rnn_21 (empty), others of kArchitectures, all
  std::filesystem::path out;          // folder, created if missing
  std::filesystem::path from;         // a known network: only its gain is fitted
  std::string finger;                 // of recordings with several
  int rest = 50;                      // samples whose mean is the rest value
  std::string optimiser = "adam";     // or sgd
  ForceTrainingOptions training;      // all but architecture, descent and seed
  std::int64_t seed = 1;              // >= 0
  int presses = 1500;                 // of `simulated`
};

extern const char* const kTrainHelp;  // text of --help below the options

// 0: trained, or stopped with a result (the files contain it); 1: no result, or not written. Throws
// std::invalid_argument for unusable options and data, and exceptions of writing.
int RunTrain(const TrainOptions& options, const std::stop_token& stop);

}  // namespace palpate
