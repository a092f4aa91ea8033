#include "slave/tactile/network/network_file.h"

#include <stdexcept>

#include "shared/text/text.h"
#include "slave/tactile/network/json_numbers.h"

namespace palpate {
namespace {

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

WeightMatrix ReadKernel(const json& layer, const std::string& name) {
  const json& rows = Member(layer, "kernel", name);
  if (!rows.is_array() || rows.empty())
    throw std::runtime_error(name + ".kernel: not a list of rows");
  WeightMatrix kernel;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string row_name = name + ".kernel[" + std::to_string(i) + "]";
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
    layers.push_back(
        {ReadKernel(layer, name), ReadNumbers(Member(layer, "bias", name), name + ".bias")});
  }
  return layers;
}

void ReadScaling(const json& root, const std::string& key, Eigen::VectorXf* mean,
                 Eigen::VectorXf* scale) {
  if (!root.contains(key)) return;
  *mean = ReadNumbers(Member(root[key], "mean", key), key + ".mean");
  *scale = ReadNumbers(Member(root[key], "scale", key), key + ".scale");
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
    if (sigma.size() != 3) throw std::runtime_error("sigma: accepted are three numbers [N]");
    for (int i = 0; i < 3; ++i) info.sigma[i] = root["sigma"][static_cast<std::size_t>(i)];
  }
  if (root.contains("learnt_force")) {
    info.learnt_force = ReadNumber(root["learnt_force"], "learnt_force");
  }
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
  return {{"palpate_force_network", kVersion},
          {"architecture", info.architecture},
          {"inputs", info.inputs},
          {"window", info.window},
          {"outputs", info.outputs},
          {"rate", info.rate},
          {"gain", info.gain},
          {"sigma", {info.sigma.x(), info.sigma.y(), info.sigma.z()}},
          {"learnt_force", info.learnt_force},
          {"origin", info.origin},
          {"training", TrainingOf(training)},
          {"input", ScalingOf(weights.input_mean, weights.input_scale)},
          {"lstm", LayersOf(weights.lstm)},
          {"dense", LayersOf(weights.dense)},
          {"activation", tanh ? "tanh" : "relu"},
          {"output", ScalingOf(weights.output_mean, weights.output_scale)}};
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
  try {
    return Parse(root);
  } catch (const std::exception& error) {
    throw std::runtime_error(file.string() + ": " + error.what());
  }
}

}  // namespace palpate
