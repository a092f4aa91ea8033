#include "slave/tactile/network/network_file.h"

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "shared/text/text.h"

namespace palpate {
namespace {

using nlohmann::json;

constexpr std::uintmax_t kMaxFile = 256u << 20;  // [bytes]
constexpr int kMaxCount = 1 << 20;
constexpr double kMaxNumber = std::numeric_limits<float>::max();

// Throws std::runtime_error naming the file if it is missing, too large or not JSON.
json ReadJsonFile(const std::filesystem::path& file) {
  const std::string text = ReadWholeFile(file, kMaxFile, "JSON");
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
  if (!(number >= 0 && number <= kMaxCount && number == std::floor(number))) {
    throw std::runtime_error(key + ": not a count from 0 to " + std::to_string(kMaxCount));
  }
  return static_cast<int>(number);
}

std::string ReadText(const json& object, const std::string& key) {
  const json& value = Member(object, key, "");
  if (!value.is_string()) throw std::runtime_error(key + ": not a text");
  return value.get<std::string>();
}

// Reads numbers that fit into single precision.
Eigen::VectorXf ReadNumbers(const json& list, const std::string& name) {
  if (!list.is_array()) throw std::runtime_error(name + ": not a list of numbers");
  Eigen::VectorXf vector(static_cast<Eigen::Index>(list.size()));
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string entry = name + "[" + std::to_string(i) + "]";
    const double number = ReadNumber(list[i], entry);
    if (std::abs(number) > kMaxNumber) {
      throw std::runtime_error(entry + ": beyond single precision");
    }
    vector[static_cast<Eigen::Index>(i)] = static_cast<float>(number);
  }
  return vector;
}

namespace fs = std::filesystem;

constexpr int kVersion = 1;
constexpr std::array<std::pair<std::string_view, HiddenActivation>, 6> kActivations{
    {{"tanh", HiddenActivation::kTanh},
     {"relu", HiddenActivation::kRelu},
     {"sigmoid", HiddenActivation::kSigmoid},
     {"elu", HiddenActivation::kElu},
     {"leaky_relu", HiddenActivation::kLeakyRelu},
     {"identity", HiddenActivation::kIdentity}}};

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

HiddenActivation ReadActivation(const json& object, HiddenActivation otherwise) {
  if (!object.contains("activation")) return otherwise;
  const std::string word = ReadText(object, "activation");
  for (const auto& [name, activation] : kActivations) {
    if (word == name) return activation;
  }
  throw std::runtime_error("activation = " + word +
                           ": expected tanh, relu, sigmoid, elu, leaky_relu or identity");
}

// Calls `read` with each layer of the list `key` and its name; `root` need not contain it.
template <typename Read>
void ForLayers(const json& root, const std::string& key, const Read& read) {
  if (!root.contains(key)) return;
  if (!root[key].is_array()) throw std::runtime_error(key + ": not a list of layers");
  for (std::size_t i = 0; i < root[key].size(); ++i) {
    read(root[key][i], key + "[" + std::to_string(i) + "]");
  }
}

void ReadLayers(const json& root, NetworkWeights* weights) {
  const auto kernel = [](const json& layer, const std::string& name) {
    return ReadRows(Member(layer, "kernel", name), name + ".kernel");
  };
  const auto vector = [](const json& layer, const std::string& name, const char* key) {
    return ReadNumbers(Member(layer, key, name), name + "." + key);
  };
  ForLayers(root, "lstm", [&](const json& layer, const std::string& name) {
    weights->lstm.push_back({kernel(layer, name), vector(layer, name, "bias")});
  });
  const HiddenActivation of_all = ReadActivation(root, HiddenActivation::kTanh);
  ForLayers(root, "dense", [&](const json& layer, const std::string& name) {
    weights->dense.push_back(
        {kernel(layer, name), vector(layer, name, "bias"), ReadActivation(layer, of_all)});
  });
}

void ReadScaling(const json& root, const std::string& key, Eigen::VectorXf* mean,
                 Eigen::VectorXf* scale) {
  if (!root.contains(key)) return;
  *mean = ReadNumbers(Member(root[key], "mean", key), key + ".mean");
  *scale = ReadNumbers(Member(root[key], "scale", key), key + ".scale");
}

// Reads the matrix `name` with this number of rows and columns.
template <typename Matrix>
void ReadMatrix(const json& root, const std::string& name, Matrix* matrix) {
  const WeightMatrix read = ReadRows(Member(root, name, "pattern"), "pattern." + name);
  if (read.rows() != matrix->rows() || read.cols() != matrix->cols()) {
    throw std::runtime_error(fmt::format("pattern.{} is {} x {}, expected {} x {}", name,
                                         read.rows(), read.cols(), matrix->rows(), matrix->cols()));
  }
  *matrix = read.cast<double>();
}

// Returns the size; 0 if it is missing.
double ReadSize(const json& root, const char* key, const std::string& where = "") {
  if (!root.contains(key)) return 0;
  const double value = ReadNumber(root[key], where + key);
  if (!(value >= 0)) throw std::runtime_error(where + key + ": expected a number >= 0");
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
      throw std::runtime_error("pattern.kinds: expected shares > 0 and covariances");
    }
    pattern.kinds.push_back(read);
  }
  return pattern;
}

// Reads the values of `count` channels. `least` is the smallest accepted number.
Eigen::VectorXd ReadChannels(const json& root, const char* key, int count, double least) {
  const std::string name = std::string("channels.") + key;
  const Eigen::VectorXf read = ReadNumbers(Member(root, key, "channels"), name);
  if (read.size() != count || read.minCoeff() < static_cast<float>(least)) {
    throw std::runtime_error(
        fmt::format("{}: expected {} numbers{}", name, count, least == 0 ? " >= 0" : ""));
  }
  return read.cast<double>();
}

std::shared_ptr<const ChannelPattern> ReadChannelPattern(const json& root, int count) {
  ChannelPattern pattern;
  const WeightMatrix read =
      ReadRows(Member(root, "expectation", "channels"), "channels.expectation");
  if (read.rows() != count || read.cols() != count) {
    throw std::runtime_error(fmt::format("channels.expectation is {} x {}, expected {} x {}",
                                         read.rows(), read.cols(), count, count));
  }
  pattern.expectation = read.cast<double>();
  pattern.tolerance = ReadChannels(root, "tolerance", count, 0);
  pattern.relative_tolerance = ReadChannels(root, "relative_tolerance", count, 0);
  pattern.below = ReadChannels(root, "below", count, 0);
  pattern.above = ReadChannels(root, "above", count, 0);
  pattern.second_difference = ReadChannels(root, "second_difference", count, 0);
  if (root.contains("baseline")) {
    pattern.baseline = ReadChannels(root, "baseline", count, -kMaxNumber);
    pattern.baseline_force = ReadSize(root, "baseline_force", "channels.");
  }
  return std::make_shared<const ChannelPattern>(std::move(pattern));
}

// Throws std::runtime_error if values are missing that the training of a sensor without electrodes
// provides.
void RequireTrained(const json& root, const char* key) {
  if (root.contains(key)) return;
  throw std::runtime_error(std::string(key) +
                           " is missing: a network with `unit` needs it; train it again with "
                           "`python3 -m palpate.train --unit`, which writes it");
}

NetworkInfo ReadInfo(const json& root) {
  NetworkInfo info;
  info.architecture = ReadText(root, "architecture");
  info.inputs = ReadCount(root, "inputs");
  info.window = ReadCount(root, "window");
  info.outputs = ReadCount(root, "outputs");
  info.rate = ReadNumber(Member(root, "rate", ""), "rate");
  if (root.contains("unit")) {
    info.channels = {info.inputs, ReadText(root, "unit")};
    info.longest_constant = ReadSize(root, "longest_constant");
    for (const char* key : {"sigma", "noise", "channels"}) RequireTrained(root, key);
    info.drift = ReadSize(root, "drift");
    info.channel_pattern = ReadChannelPattern(root["channels"], info.inputs);
  }
  if (root.contains("noise")) info.noise = ReadNumber(root["noise"], "noise");
  if (root.contains("contact_point")) {
    if (!root["contact_point"].is_boolean()) {
      throw std::runtime_error("contact_point: expected true or false");
    }
    info.gives_contact_point = root["contact_point"].get<bool>();
  }
  if (root.contains("gain")) info.gain = ReadNumber(root["gain"], "gain");
  if (root.contains("sigma")) {
    const Eigen::VectorXf sigma = ReadNumbers(root["sigma"], "sigma");
    if (sigma.size() != 3 || sigma.minCoeff() < 0) {
      throw std::runtime_error("sigma: expected three numbers >= 0 [N]");
    }
    for (int i = 0; i < 3; ++i) info.sigma[i] = root["sigma"][static_cast<std::size_t>(i)];
    if (root.contains("unit") && !(info.sigma.norm() > 0)) {
      throw std::runtime_error("sigma: expected a number > 0 with `unit` [N]");
    }
  }
  info.learnt_force = ReadSize(root, "learnt_force");
  info.rest_sigma = ReadSize(root, "rest_sigma");
  info.error = ReadErrorLaw(root, "");
  if (root.contains("pattern")) info.pattern = ReadPattern(root["pattern"]);
  if (root.contains("origin")) info.origin = ReadText(root, "origin");
  return info;
}

NetworkFile Parse(const json& root) {
  if (ReadCount(root, "palpate_force_network") != kVersion) {
    throw std::runtime_error("palpate_force_network: expected " + std::to_string(kVersion));
  }
  NetworkFile file;
  file.info = ReadInfo(root);
  NetworkWeights& weights = file.weights;
  weights.LeaveUnscaled(file.info.inputs, file.info.outputs);
  ReadScaling(root, "input", &weights.input_mean, &weights.input_scale);
  ReadScaling(root, "output", &weights.output_mean, &weights.output_scale);
  ReadLayers(root, &weights);
  const std::string fault = FaultOf(file.info, weights);
  if (!fault.empty()) throw std::runtime_error(fault);
  return file;
}

}  // namespace

NetworkFile ReadForceNetwork(const fs::path& dir) {
  const fs::path file = dir / kNetworkFileName;
  const json root = ReadJsonFile(file);
  return NamingFile(file, [&] { return Parse(root); });
}

std::unique_ptr<ForceNetwork> LoadForceNetwork(const fs::path& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) {
    throw std::runtime_error(path.string() + ": there is no such file or folder");
  }
  if (!fs::is_directory(path, ignored)) {
    throw std::runtime_error(
        path.string() + ": expected a folder with " + kNetworkFileName +
        "; `python3 -m palpate.convert_network` makes one of a PyTorch module");
  }
  if (!fs::exists(path / kNetworkFileName, ignored)) {
    const bool has_tensors = fs::exists(path / "tensors.json", ignored);
    throw std::runtime_error(
        path.string() + ": contains no " + kNetworkFileName +
        (has_tensors ? "; `python3 -m palpate.convert_network` makes it of tensors.json" : ""));
  }
  const NetworkFile file = ReadForceNetwork(path);
  return MakeForceNetwork(file.info, file.weights);
}

}  // namespace palpate
