// The formulas of force networks as FORMAT.md has them, in double precision, one sample and one
// unit at a time: the reference of the tested networks.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "slave/tactile/network/network_weights.h"

namespace palpate {

// The outputs after `samples`, from the state of zero.
std::vector<double> ReferenceOutputs(const NetworkInfo& info, const NetworkWeights& weights,
                                     std::span<const TactileSignals> samples);
// The last recurrent layer's h.
std::vector<double> ReferenceState(const NetworkWeights& weights,
                                   std::span<const TactileSignals> samples);

// A network with random weights: two lstm layers of `units` for rnn_*, two hidden layers for dnn_*
// and tnn_*, uniform within +-size; inputs are scaled so that 100 counts are about 1.
struct RandomNetwork {
  NetworkInfo info;
  NetworkWeights weights;
};
RandomNetwork MakeRandomNetwork(const std::string& architecture, int units, float size,
                                unsigned seed);

// Returns the JSON file of the network.
nlohmann::json JsonOf(const RandomNetwork& network);

// The weights of paper B's authors in DIR/tensors.json: `{name: {shape, data}}`, data row-major.
RandomNetwork AuthorsNetwork(const std::filesystem::path& dir);

// Changes as a finger makes them: each signal wanders by up to `counts`.
std::vector<TactileSignals> RandomSignals(int count, float counts, unsigned seed);

}  // namespace palpate
