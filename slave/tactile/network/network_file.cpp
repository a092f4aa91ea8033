#include "slave/tactile/network/network_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

using nlohmann::json;

constexpr std::uintmax_t kLargestFile = 256u << 20;  // [bytes]
constexpr int kLargestCount = 1 << 20;
constexpr double kLargestNumber = std::numeric_limits<float>::max();

// Throws std::runtime_error naming the file: missing, larger than a network can be, not JSON.
json ReadJsonFile(const std::filesystem::path& file) {
  const std::string text = ReadWholeFile(file, kLargestFile, "JSON");
  try {
    return json::parse(text);
  } catch (const json::exception& broken) {
    throw std::runtime_error(file.string() + ": not JSON: " + broken.what());
  }
}

// The functions below throw std::runtime_error naming `name` or `name.key` and what is accepted.
const json& Member(const json& object, const std::string& key, const std::string& name) {
  const std::string full = name.empty() ? key : name + "." + key;
  if (!object.is_object() || !object.contains(key)) throw std::runtime_error(full + " is missing");
  return object[key];
}

double ReadNumber(const json& value, const std::string& name) {
  if (!value.is_number()) throw std::runtime_error(name + ": not a number");
  const auto number = value.get<double>();
  if (!std::isfinite(number)) throw std::runtime_error(name + ": not a finite number");
  return number;
}

int ReadCount(const json& object, const std::string& key) {
  const double number = ReadNumber(Member(object, key, ""), key);
  if (!(number >= 0 && number <= kLargestCount && number == std::floor(number))) {
    throw std::runtime_error(key + ": not a count from 0 to " + std::to_string(kLargestCount));
  }
  return static_cast<int>(number);
}

std::string ReadText(const json& object, const std::string& key) {
  const json& value = Member(object, key, "");
  if (!value.is_string()) throw std::runtime_error(key + ": not a text");
  return value.get<std::string>();
}

// Numbers that fit into single precision.
Eigen::VectorXf ReadNumbers(const json& list, const std::string& name) {
  if (!list.is_array()) throw std::runtime_error(name + ": not a list of numbers");
  Eigen::VectorXf vector(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string entry = name + "[" + std::to_string(i) + "]";
    const double number = ReadNumber(list[i], entry);
    if (std::abs(number) > kLargestNumber) {
      throw std::runtime_error(entry + ": beyond single precision");
    }
    vector[static_cast<Eigen::Index>(i)] = static_cast<float>(number);
  }
  return vector;
}

// The shortest digits that single precision reads back, half as many as of the same number in
// double precision.
json NumbersOf(const Eigen::VectorXf& vector) {
  json list = json::array();
  for (const float number : vector) {
    std::array<char, 32> text;
    const auto end = std::to_chars(text.begin(), text.end(), number).ptr;
    double written = 0;
    std::from_chars(text.begin(), end, written);
    const bool reads_back =
        std::abs(written) <= kLargestNumber && static_cast<float>(written) == number;
    list.push_back(reads_back ? written : static_cast<double>(number));
  }
  return list;
}

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kVersion = 1;

json RowsOf(const WeightMatrix& matrix) {
  json rows = json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    rows.push_back(NumbersOf(Eigen::VectorXf(matrix.row(i))));
  }
  return rows;
}

template <typename Layer>
json LayersOf(const std::vector<Layer>& layers) {
  json list = json::array();
  for (const Layer& layer : layers) {
    list.push_back({{"kernel", RowsOf(layer.kernel)}, {"bias", NumbersOf(layer.bias)}});
  }
  return list;
}

json ScalingOf(const Eigen::VectorXf& mean, const Eigen::VectorXf& scale) {
  return {{"mean", NumbersOf(mean)}, {"scale", NumbersOf(scale)}};
}

json TrainingOf(const std::string& text) {
  json training = json::parse(text, nullptr, false);
  if (!training.is_object()) throw std::invalid_argument("training summary: not a JSON object");
  return training;
}

WeightMatrix ReadRows(const json& rows, const std::string& name) {
  if (!rows.is_array() || rows.empty()) throw std::runtime_error(name + ": not a list of rows");
  WeightMatrix kernel;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string row_name = name + "[" + std::to_string(i) + "]";
    const Eigen::VectorXf row = ReadNumbers(rows[i], row_name);
    if (i == 0) kernel.resize(static_cast<Eigen::Index>(rows.size()), row.size());
    if (row.size() != kernel.cols()) {
      throw std::runtime_error(row_name + " has " + std::to_string(row.size()) +
                               " numbers, expected " + std::to_string(kernel.cols()));
    }
    kernel.row(static_cast<Eigen::Index>(i)) = row;
  }
  return kernel;
}

template <typename Layer>
std::vector<Layer> ReadLayers(const json& root, const std::string& key) {
  std::vector<Layer> layers;
  if (!root.contains(key)) return layers;
  if (!root[key].is_array()) throw std::runtime_error(key + ": not a list of layers");
  for (const json& layer : root[key]) {
    const std::string name = key + "[" + std::to_string(layers.size()) + "]";
    layers.push_back({ReadRows(Member(layer, "kernel", name), name + ".kernel"),
                      ReadNumbers(Member(layer, "bias", name), name + ".bias")});
  }
  return layers;
}

void ReadScaling(const json& root, const std::string& key, Eigen::VectorXf* mean,
                 Eigen::VectorXf* scale) {
  if (!root.contains(key)) return;
  *mean = ReadNumbers(Member(root[key], "mean", key), key + ".mean");
  *scale = ReadNumbers(Member(root[key], "scale", key), key + ".scale");
}

// `name` as so many rows and columns.
template <typename Matrix>
void ReadMatrix(const json& root, const std::string& name, Matrix* matrix) {
  const WeightMatrix read = ReadRows(Member(root, name, "pattern"), "pattern." + name);
  if (read.rows() != matrix->rows() || read.cols() != matrix->cols()) {
    throw std::runtime_error(fmt::format("pattern.{} is {} x {}, expected {} x {}", name,
                                         read.rows(), read.cols(), matrix->rows(), matrix->cols()));
  }
  *matrix = read.cast<double>();
}

// 0 where there is none.
double ReadSize(const json& root, const char* key, const std::string& where = "") {
  if (!root.contains(key)) return 0;
  const double value = ReadNumber(root[key], where + key);
  if (!(value >= 0)) throw std::runtime_error(where + key + ": accepted is a number >= 0");
  return value;
}

ForceErrorLaw ReadErrorLaw(const json& root, const std::string& where) {
  return {ReadSize(root, "growing_variance", where), ReadSize(root, "relative_sigma", where)};
}

SignalPattern ReadPattern(const json& root) {
  SignalPattern pattern;
  ReadMatrix(root, "force", &pattern.force);
  for (const json& kind : Member(root, "kinds", "pattern")) {
    SignalPattern::Kind read;
    read.share = ReadNumber(Member(kind, "share", "pattern.kinds"), "pattern.kinds.share");
    ReadMatrix(kind, "shape", &read.shape);
    read.error = ReadErrorLaw(kind, "pattern.kinds.");
    const Eigen::LLT<SignalPattern::Covariance> factor(read.shape);
    if (!(read.share > 0 && factor.info() == Eigen::Success)) {
      throw std::runtime_error("pattern.kinds: accepted are shares > 0 and covariances");
    }
    pattern.kinds.push_back(read);
  }
  return pattern;
}

json PatternJson(const SignalPattern& pattern) {
  json kinds = json::array();
  for (const SignalPattern::Kind& kind : pattern.kinds) {
    kinds.push_back({{"share", kind.share},
                     {"shape", RowsOf(kind.shape.cast<float>())},
                     {"growing_variance", kind.error.growing},
                     {"relative_sigma", kind.error.relative}});
  }
  return {{"kinds", kinds}, {"force", RowsOf(pattern.force.cast<float>())}};
}

NetworkInfo ReadInfo(const json& root) {
  NetworkInfo info;
  info.architecture = ReadText(root, "architecture");
  info.inputs = ReadCount(root, "inputs");
  info.window = ReadCount(root, "window");
  info.outputs = ReadCount(root, "outputs");
  info.rate = ReadNumber(Member(root, "rate", ""), "rate");
  if (root.contains("gain")) info.gain = ReadNumber(root["gain"], "gain");
  if (root.contains("sigma")) {
    const Eigen::VectorXf sigma = ReadNumbers(root["sigma"], "sigma");
    if (sigma.size() != 3 || sigma.minCoeff() < 0) {
      throw std::runtime_error("sigma: accepted are three numbers >= 0 [N]");
    }
    for (int i = 0; i < 3; ++i) info.sigma[i] = root["sigma"][static_cast<std::size_t>(i)];
  }
  info.learnt_force = ReadSize(root, "learnt_force");
  info.rest_sigma = ReadSize(root, "rest_sigma");
  info.error = ReadErrorLaw(root, "");
  if (root.contains("pattern")) info.pattern = ReadPattern(root["pattern"]);
  if (root.contains("origin")) info.origin = ReadText(root, "origin");
  return info;
}

HiddenActivation ReadActivation(const json& root) {
  if (!root.contains("activation")) return HiddenActivation::kTanh;
  const std::string word = ReadText(root, "activation");
  if (word == "relu") return HiddenActivation::kRelu;
  if (word == "tanh") return HiddenActivation::kTanh;
  throw std::runtime_error("activation = " + word + ": accepted is tanh or relu");
}

NetworkFile Parse(const json& root) {
  if (ReadCount(root, "palpate_force_network") != kVersion) {
    throw std::runtime_error("palpate_force_network: accepted is " + std::to_string(kVersion));
  }
  NetworkFile file;
  file.info = ReadInfo(root);
  NetworkWeights& weights = file.weights;
  weights.LeaveUnscaled(file.info.inputs, file.info.outputs);
  ReadScaling(root, "input", &weights.input_mean, &weights.input_scale);
  ReadScaling(root, "output", &weights.output_mean, &weights.output_scale);
  weights.lstm = ReadLayers<LstmLayer>(root, "lstm");
  weights.dense = ReadLayers<DenseLayer>(root, "dense");
  weights.activation = ReadActivation(root);
  if (root.contains("training")) file.training = root["training"].dump();
  const std::string fault = FaultOf(file.info, weights);
  if (!fault.empty()) throw std::runtime_error(fault);
  return file;
}

json Document(const NetworkInfo& info, const NetworkWeights& weights, const std::string& training) {
  const bool tanh = weights.activation == HiddenActivation::kTanh;
  json document = {{"palpate_force_network", kVersion},
                   {"architecture", info.architecture},
                   {"inputs", info.inputs},
                   {"window", info.window},
                   {"outputs", info.outputs},
                   {"rate", info.rate},
                   {"gain", info.gain},
                   {"sigma", {info.sigma.x(), info.sigma.y(), info.sigma.z()}},
                   {"rest_sigma", info.rest_sigma},
                   {"growing_variance", info.error.growing},
                   {"relative_sigma", info.error.relative},
                   {"learnt_force", info.learnt_force},
                   {"origin", info.origin},
                   {"training", TrainingOf(training)},
                   {"input", ScalingOf(weights.input_mean, weights.input_scale)},
                   {"lstm", LayersOf(weights.lstm)},
                   {"dense", LayersOf(weights.dense)},
                   {"activation", tanh ? "tanh" : "relu"},
                   {"output", ScalingOf(weights.output_mean, weights.output_scale)}};
  if (info.pattern.known()) document["pattern"] = PatternJson(info.pattern);
  return document;
}

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
  info.origin = "weights by the authors of paper B, trained on forces of 0.1 to 1.0 N (IV.A)";
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

void WriteForceNetwork(const fs::path& dir, const NetworkInfo& info, const NetworkWeights& weights,
                       const std::string& training) {
  const std::string fault = FaultOf(info, weights);
  if (!fault.empty()) throw std::invalid_argument(fault);
  const std::string text =
      Document(info, weights, training).dump(-1, ' ', false, json::error_handler_t::replace);
  std::error_code error;
  fs::create_directories(dir, error);
  ReplaceFile(dir / kNetworkFileName, text + '\n');
}

NetworkFile ReadForceNetwork(const fs::path& dir) {
  const fs::path file = dir / kNetworkFileName;
  const json root = ReadJsonFile(file);
  return NamingFile(file, [&] { return Parse(root); });
}

std::unique_ptr<ForceNetwork> LoadForceNetwork(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw std::runtime_error(path.string() + ": there is no such file or folder");
  }
  if (!std::filesystem::is_directory(path, ignored)) return LoadOnnxNetwork(path);
  const bool own = std::filesystem::exists(path / kNetworkFileName, ignored);
  if (!own && !std::filesystem::exists(path / kTensorsFileName, ignored)) {
    throw std::runtime_error(path.string() + ": contains neither " + kNetworkFileName + " nor " +
                             kTensorsFileName);
  }
  const NetworkFile file = own ? ReadForceNetwork(path) : ImportTensors(path);
  return MakeForceNetwork(file.info, file.weights);
}

Tensors ReadTensors(const fs::path& file) {
  const json root = ReadJsonFile(file);
  return NamingFile(file, [&] {
    if (!root.is_object()) throw std::runtime_error("not an object of tensors");
    Tensors tensors;
    for (const auto& [name, value] : root.items()) {
      tensors[name] = ReadTensor(value, "tensor " + name);
    }
    return tensors;
  });
}

NetworkFile ImportTensors(const fs::path& dir) {
  const fs::path file = dir / kTensorsFileName;
  const Tensors tensors = ReadTensors(file);
  return NamingFile(file, [&] { return Assemble(tensors); });
}

}  // namespace palpate
