// A force network in a folder: `network.json`, described in FORMAT.md.
#pragma once

#include <filesystem>
#include <string>

#include "slave/tactile/network/network_weights.h"

namespace palpate {

inline constexpr const char* kNetworkFileName = "network.json";

struct NetworkFile {
  NetworkInfo info;
  NetworkWeights weights;
  std::string training = "{}";  // how it came about: text of a JSON object, kept as it is
};

// Writes DIR/network.json, making DIR where it is missing; every number round-trips exactly. The
// file appears whole or not at all. Throws std::invalid_argument for weights that do not fit
// (FaultOf) or `training` that is no JSON object, std::runtime_error naming a file that cannot be
// written.
void WriteForceNetwork(const std::filesystem::path& dir, const NetworkInfo& info,
                       const NetworkWeights& weights, const std::string& training = "{}");

// Throws std::runtime_error naming the file and what is wrong with it, as LoadForceNetwork does.
NetworkFile ReadForceNetwork(const std::filesystem::path& dir);

}  // namespace palpate
