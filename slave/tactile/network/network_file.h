// Force networks in files: `network.json`, see FORMAT.md.
#pragma once

#include <filesystem>

#include "slave/tactile/network/force_network.h"
#include "slave/tactile/network/network_weights.h"

namespace palpate {

inline constexpr const char* kNetworkFileName = "network.json";

struct NetworkFile {
  NetworkInfo info;
  NetworkWeights weights;
};

// Reads DIR/network.json. Throws std::runtime_error naming the file and the error, as
// LoadForceNetwork does.
NetworkFile ReadForceNetwork(const std::filesystem::path& dir);

}  // namespace palpate
