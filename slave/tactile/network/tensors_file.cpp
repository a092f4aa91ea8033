#include "slave/tactile/network/tensors_file.h"

#include <optional>
#include <stdexcept>

#include "slave/tactile/network/json_numbers.h"

namespace palpate {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kLargestExtent = 1 << 20;
constexpr double kLearntForce = 1.0;  // paper B, IV.A [N]

std::string InWords(const std::vector<int>& shape) {
  std::string words;
  for (const int extent : shape) words += (words.empty() ? "" : " x ") + std::to_string(extent);
  return words.empty() ? "a single number" : words;
}

std::vector<int> ReadShape(const json& list, const std::string& name) {
  if (!list.is_array()) throw std::runtime_error(name + ": not a list of numbers");
  std::vector<int> shape;
  for (const json& extent : list) {
    const double number = ReadNumber(extent, name);
    if (!(number >= 1 && number <= kLargestExtent)) {
      throw std::runtime_error(name + ": accepted are extents from 1 to " +
                               std::to_string(kLargestExtent));
    }
    shape.push_back(static_cast<int>(number));
  }
  return shape;
}

Tensor ReadTensor(const json& value, const std::string& name) {
  Tensor tensor;
  tensor.shape = ReadShape(Member(value, "shape", name), name + ".shape");
  const Eigen::VectorXf data = ReadNumbers(Member(value, "data", name), name + ".data");
  tensor.data.assign(data.begin(), data.end());
  double expected = 1;
  for (const int extent : tensor.shape) expected *= extent;
  if (static_cast<double>(tensor.data.size()) != expected) {
    throw std::runtime_error(name + ".data has " + std::to_string(tensor.data.size()) +
                             " numbers, its shape is " + InWords(tensor.shape));
  }
  return tensor;
}

// The only tensor whose name begins with `layer` and ends with `kind`; nullptr: there is none.
const Tensor* Find(const Tensors& tensors, const std::string& layer, const std::string& kind) {
  for (const auto& [name, tensor] : tensors) {
    if (name.starts_with(layer + "/") && name.ends_with("/" + kind)) return &tensor;
  }
  return nullptr;
}

const Tensor& Require(const Tensors& tensors, const std::string& layer, const std::string& kind,
                      std::size_t rank) {
  const Tensor* tensor = Find(tensors, layer, kind);
  if (!tensor) throw std::runtime_error("tensor " + layer + "/.../" + kind + " is missing");
  if (tensor->shape.size() != rank) {
    throw std::runtime_error("tensor " + layer + "/.../" + kind + " is " + InWords(tensor->shape) +
                             ", expected " + (rank == 2 ? "rows x columns" : "a list"));
  }
  return *tensor;
}

template <typename Layer>
Layer ReadLayer(const Tensors& tensors, const std::string& layer, const std::string& kernel,
                const std::string& bias) {
  const Tensor& matrix = Require(tensors, layer, kernel, 2);
  const Tensor& vector = Require(tensors, layer, bias, 1);
  return {Eigen::Map<const WeightMatrix>(matrix.data.data(), matrix.shape[0], matrix.shape[1]),
          Eigen::Map<const Eigen::VectorXf>(vector.data.data(), vector.shape[0])};
}

NetworkFile Assemble(const Tensors& tensors) {
  constexpr int kWindow = 50;
  NetworkFile file;
  NetworkWeights& weights = file.weights;
  for (int k = 1; k == 1 || Find(tensors, "layer" + std::to_string(k), "Matrix"); ++k) {
    const std::string layer = "layer" + std::to_string(k);
    weights.lstm.push_back(ReadLayer<LstmLayer>(tensors, layer, "Matrix", "Bias"));
  }
  weights.dense.push_back(ReadLayer<DenseLayer>(tensors, "output_layer", "W", "b"));
  NetworkInfo& info = file.info;
  info.inputs = static_cast<int>(weights.lstm.front().kernel.rows() - weights.lstm.front().units());
  info.outputs = static_cast<int>(weights.dense.back().kernel.cols());
  info.window = kWindow;
  info.architecture = "rnn_" + std::to_string(info.inputs);
  info.learnt_force = kLearntForce;
  info.origin = "weights of the authors of paper B, learnt from forces of 0.1 to 1.0 N (IV.A)";
  if (InputsOf(info.architecture) == 0) {
    throw std::runtime_error("the network takes " + std::to_string(info.inputs) +
                             " inputs and gives " + std::to_string(info.outputs) +
                             " outputs: a fingertip has 21 signals or 19");
  }
  weights.LeaveUnscaled(info.inputs, info.outputs);
  const std::string fault = FaultOf(info, weights);
  if (!fault.empty()) throw std::runtime_error(fault);
  return file;
}

}  // namespace

Tensors ReadTensors(const fs::path& file) {
  const json root = ReadJsonFile(file);
  try {
    if (!root.is_object()) throw std::runtime_error("not an object of tensors");
    Tensors tensors;
    for (const auto& [name, value] : root.items()) {
      tensors[name] = ReadTensor(value, "tensor " + name);
    }
    return tensors;
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

NetworkFile ImportTensors(const fs::path& dir) {
  const fs::path file = dir / kTensorsFileName;
  const Tensors tensors = ReadTensors(file);
  try {
    return Assemble(tensors);
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace palpate
