// Weights in the layout in which those of paper B's authors survive: `tensors.json`, see FORMAT.md.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "slave/tactile/network/network_file.h"

namespace palpate {

inline constexpr const char* kTensorsFileName = "tensors.json";

struct Tensor {
  std::vector<int> shape;   // empty: a single number
  std::vector<float> data;  // row-major
};
using Tensors = std::map<std::string, Tensor>;

// Of any shapes. Throws std::runtime_error naming file, tensor and what is wrong: data that does
// not fill the shape, a number that is not finite.
Tensors ReadTensors(const std::filesystem::path& file);

// The network that DIR/tensors.json holds. Its error is not known: sigma and learnt_force are 0.
// Throws std::runtime_error naming the file and what is wrong: as ReadTensors; a tensor missing or
// of the wrong shape (which, expected); not 21 or 19 inputs.
NetworkFile ImportTensors(const std::filesystem::path& dir);

}  // namespace palpate
