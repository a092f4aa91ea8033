// A localiser fitted to measured contact normals.
#pragma once

#include "slave/commands/train/train.h"

namespace palpate {

// As RunTrain; writes DIR/localiser.json.
int TrainLocaliser(const TrainOptions& options);

}  // namespace palpate
