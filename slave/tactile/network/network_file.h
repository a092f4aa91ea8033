// Force networks in files: `network.json` and `tensors.json` in folders, see FORMAT.md, and ONNX.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "slave/tactile/network/force_network.h"
#include "slave/tactile/network/network_weights.h"

namespace palpate {

inline constexpr const char* kNetworkFileName = "network.json";

struct NetworkFile {
  NetworkInfo info;
  NetworkWeights weights;
  std::string training = "{}";  // training summary: text of a JSON object, unchanged
};

// Writes DIR/network.json, making DIR where it is missing; every number round-trips exactly. The
// file appears whole or not at all. Throws std::invalid_argument for weights that do not fit
// (FaultOf) or `training` that is no JSON object, std::runtime_error naming a file that cannot be
// written.
void WriteForceNetwork(const std::filesystem::path& dir, const NetworkInfo& info,
                       const NetworkWeights& weights, const std::string& training = "{}");

// Throws std::runtime_error naming the file and the error, as LoadForceNetwork does.
NetworkFile ReadForceNetwork(const std::filesystem::path& dir);

// Weights in the layout of those of paper B's authors: `tensors.json`, see FORMAT.md.
inline constexpr const char* kTensorsFileName = "tensors.json";

struct Tensor {
  std::vector<int> shape;   // empty: a single number
  std::vector<float> data;  // row-major
};
using Tensors = std::map<std::string, Tensor>;

// Tensors of any shape. Throws std::runtime_error naming file, tensor and error: data that do not
// fill the shape, a number that is not finite.
Tensors ReadTensors(const std::filesystem::path& file);

// The network in DIR/tensors.json. Its error is unknown: sigma and learnt_force are 0. Throws
// std::runtime_error naming the file and the error: as ReadTensors; a tensor missing or of the
// wrong shape (which, expected); not 21 or 19 inputs.
NetworkFile ImportTensors(const std::filesystem::path& dir);

// An ONNX file, run by OpenCV: a model with one input, [1, n] or [1, window, n] with n = 21 or 19
// counts minus baseline and at most 1000 samples (window 50 if the model leaves it open). Its first
// output must be one row of 3 or more numbers that begins with the force of the fingertip on the
// object, frame F [N]. Its estimates allocate memory in OpenCV. Throws std::runtime_error naming
// the file and the error: not ONNX, truncated, other shapes, an operator that OpenCV does not
// support (its name).
std::unique_ptr<ForceNetwork> LoadOnnxNetwork(const std::filesystem::path& file);

}  // namespace palpate
