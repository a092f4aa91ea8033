// Learns the force from tactile samples (paper B, III.A.1 and IV.A).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "shared/text/progress.h"
#include "slave/tactile/network/network_weights.h"
#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

inline constexpr int kNetworkWindow = 50;  // window size of recurrent networks
inline constexpr int kLstmUnits = 20;      // per layer, two layers
inline constexpr int kTraceUnits = 64;     // per hidden layer of networks of traces, two layers
inline constexpr int kDenseUnits = 38;     // per hidden layer, two layers: twice 19 (Su et al.)

struct ForceTrainingOptions {
  std::string architecture = "rnn_21";  // kArchitectures
  enum class Descent : std::uint8_t { kAdam, kSgd } descent = Descent::kAdam;
  double rate = 0;         // learning rate; 0: 0.01 for SGD, constant as in the paper; 0.004 for
                           // Adam, falling to nothing along half a cosine over the epochs
  int epochs = 60;         // at most, >= 1
  int patience = 20;       // epochs without a better validation before it stops, >= 1
  int batch = 128;         // windows per step, >= 1
  int epoch_size = 16384;  // windows per epoch, drawn in turn from all of them; >= 1
  std::uint64_t seed = 1;  // the same seed gives the same weights, independent of `threads`
  int threads = 2;         // >= 1
};

struct TrainingEpoch {
  int epoch = 0;    // from 1
  double loss = 0;  // mean squared error over axes of unit size, weighted, training windows
  double validation_loss = 0;
};

// The result of training.
struct LearntForce {
  NetworkInfo info;        // sigma is to be set from a test
  NetworkWeights weights;  // of the best epoch
  std::vector<TrainingEpoch> epochs;
  int best_epoch = 0;
  std::size_t train_windows = 0, validation_windows = 0;
  bool stopped = false;  // on request, before its time
};

// Trains on the split's stretches. Signals are scaled by their size in training, the baseline stays
// 0. `progress` reports the architecture; if it requests a stop, training returns the best weights
// so far. Throws std::invalid_argument: an option (which, what is accepted), too few windows,
// signals or forces that do not vary or are not finite; Interrupted: stopped before the end of the
// first epoch.
LearntForce TrainForce(std::span<const LabelledRecording> recordings, const Split& split,
                       const ForceTrainingOptions& options, Progress& progress);

}  // namespace palpate
