// Force networks, trained on the data of the command line.
#pragma once

#include <stop_token>

#include "slave/commands/train/train.h"

namespace palpate {

// As RunTrain. Several networks go into folders of their names.
int TrainForceNetworks(const TrainOptions& options, const std::stop_token& stop);

// Fits the gain of the known network options.from. As RunTrain.
int TrainForceGain(const TrainOptions& options);

}  // namespace palpate
