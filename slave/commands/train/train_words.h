// What `train` prints and writes beside its networks.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "slave/tactile/training/estimate_errors.h"
#include "slave/tactile/training/force_trainer.h"

namespace palpate {

struct TestedNetwork {
  std::string architecture;
  ForceErrors errors;
};
// The paper's table I: RMSE in mN and SMSE per axis.
std::string ForceTable(std::span<const TestedNetwork> networks);

// Root mean square, correlation and what happens at the peak of fz, in a line.
std::string AlongNormal(const ForceErrors& errors);

// epoch,loss,validation_loss. Throws std::runtime_error naming the file.
void WriteEpochs(const std::filesystem::path& file, std::span<const TrainingEpoch> epochs);

// Makes `dir` where it is missing and tries to write there. Throws std::runtime_error naming it.
void MakeWritable(const std::filesystem::path& dir);

}  // namespace palpate
