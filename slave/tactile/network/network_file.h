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

// Weights in the layout in which those of paper B's authors survive: `tensors.json`, see FORMAT.md.
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

// An ONNX file, run by OpenCV: a model with one input, [1, n] or [1, window, n] with n = 21 or 19
// counts minus rest and at most 1000 samples (window 50 where the model leaves it open), whose
// first output holds one row of 3 or more numbers, the force of the fingertip on the object, frame
// F [N], first. Its estimates allocate: OpenCV does. Throws std::runtime_error naming the file and
// what is wrong: no ONNX, cut off, other shapes, an operator that OpenCV does not run (its name).
std::unique_ptr<ForceNetwork> LoadOnnxNetwork(const std::filesystem::path& file);

}  // namespace palpate
