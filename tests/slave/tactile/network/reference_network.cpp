#include "tests/slave/tactile/network/reference_network.h"

#include <cmath>
#include <fstream>
#include <random>
#include <string>

#include <nlohmann/json.hpp>

namespace palpate {
namespace {

using Vector = std::vector<double>;

double Sigmoid(double z) {
  return 1 / (1 + std::exp(-z));
}

Vector Scaled(const NetworkWeights& weights, const TactileSignals& change) {
  Vector x;
  for (Eigen::Index i = 0; i < weights.input_mean.size(); ++i) {
    const double value = change[static_cast<std::size_t>(i)];
    x.push_back((value - static_cast<double>(weights.input_mean[i])) /
                static_cast<double>(weights.input_scale[i]));
  }
  return x;
}

void Step(const LstmLayer& layer, const Vector& x, Vector* c, Vector* h) {
  const auto n = static_cast<std::size_t>(layer.units());
  Vector row = x;
  row.insert(row.end(), h->begin(), h->end());
  Vector z(4 * n);
  for (std::size_t column = 0; column < 4 * n; ++column) {
    const auto j = static_cast<Eigen::Index>(column);
    z[column] = static_cast<double>(layer.bias[j]);
    for (std::size_t k = 0; k < row.size(); ++k) {
      z[column] += row[k] * static_cast<double>(layer.kernel(static_cast<Eigen::Index>(k), j));
    }
  }
  for (std::size_t u = 0; u < n; ++u) {
    (*c)[u] = (*c)[u] * Sigmoid(z[2 * n + u] + 1) + Sigmoid(z[u]) * std::tanh(z[n + u]);
    (*h)[u] = std::tanh((*c)[u]) * Sigmoid(z[3 * n + u]);
  }
}

double Activated(HiddenActivation activation, double y) {
  switch (activation) {
    case HiddenActivation::kTanh:
      return std::tanh(y);
    case HiddenActivation::kRelu:
      return y > 0 ? y : 0;
    case HiddenActivation::kSigmoid:
      return Sigmoid(y);
    case HiddenActivation::kElu:
      return y > 0 ? y : std::expm1(y);
    case HiddenActivation::kLeakyRelu:
      return y > 0 ? y : 0.01 * y;
    case HiddenActivation::kIdentity:
      break;
  }
  return y;
}

Vector Dense(const DenseLayer& layer, const Vector& x) {
  Vector y;
  for (Eigen::Index j = 0; j < layer.kernel.cols(); ++j) {
    double sum = static_cast<double>(layer.bias[j]);
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += x[i] * static_cast<double>(layer.kernel(static_cast<Eigen::Index>(i), j));
    }
    y.push_back(sum);
  }
  return y;
}

struct Traced {
  Vector features;
  double size = 0;
};

Traced TracesOf(const NetworkInfo& info, const NetworkWeights& weights,
                std::span<const TactileSignals> samples) {
  const Vector now = Scaled(weights, samples.back());
  Traced traced{now, 0.01};
  for (std::size_t i = 0; i < 19; ++i) traced.size += now[i] * now[i] / 19;
  traced.size = std::sqrt(traced.size);
  for (const double time : {0.02, 0.06, 0.3, 1.0, 3.0}) {
    Vector mean(now.size(), 0.0);
    for (const TactileSignals& sample : samples) {
      const Vector x = Scaled(weights, sample);
      for (std::size_t i = 0; i < x.size(); ++i) {
        mean[i] += (1 - std::exp(-1 / (time * info.rate))) * (x[i] - mean[i]);
      }
    }
    traced.features.insert(traced.features.end(), mean.begin(), mean.end());
  }
  for (double& feature : traced.features) feature /= traced.size;
  return traced;
}

Vector InputOf(const NetworkWeights& weights, std::span<const TactileSignals> samples) {
  return weights.lstm.empty() ? Scaled(weights, samples.back()) : ReferenceState(weights, samples);
}

}  // namespace

Vector ReferenceState(const NetworkWeights& weights, std::span<const TactileSignals> samples) {
  std::vector<Vector> c, h;
  for (const LstmLayer& layer : weights.lstm) {
    c.emplace_back(layer.units(), 0.0);
    h.emplace_back(layer.units(), 0.0);
  }
  for (const TactileSignals& sample : samples) {
    Vector x = Scaled(weights, sample);
    for (std::size_t k = 0; k < weights.lstm.size(); ++k) {
      Step(weights.lstm[k], x, &c[k], &h[k]);
      x = h[k];
    }
  }
  return h.back();
}

Vector ReferenceOutputs(const NetworkInfo& info, const NetworkWeights& weights,
                        std::span<const TactileSignals> samples) {
  const bool is_traced = IsTraced(info.architecture);
  const Traced traced = is_traced ? TracesOf(info, weights, samples) : Traced{{}, 1};
  Vector y = is_traced ? traced.features : InputOf(weights, samples);
  for (const DenseLayer& layer : weights.dense) {
    y = Dense(layer, y);
    if (&layer == &weights.dense.back()) break;
    for (double& value : y) value = Activated(layer.activation, value);
  }
  for (std::size_t k = 0; k < y.size(); ++k) {
    const auto j = static_cast<Eigen::Index>(k);
    y[k] = traced.size * info.gain *
           (static_cast<double>(weights.output_mean[j]) +
            static_cast<double>(weights.output_scale[j]) * y[k]);
  }
  return y;
}

RandomNetwork MakeRandomNetwork(const std::string& architecture, int units, float size,
                                unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> within(-size, size);
  const auto number = [&] { return within(random); };
  RandomNetwork made;
  NetworkInfo& info = made.info;
  info.architecture = architecture;
  info.inputs = InputsOf(architecture, true);
  const bool is_traced = IsTraced(architecture);
  info.window = IsRecurrent(architecture) || is_traced ? 50 : 1;
  info.outputs = 4;
  info.gain = 1.25;
  NetworkWeights& weights = made.weights;
  weights.LeaveUnscaled(info.inputs, info.outputs);
  if (!is_traced) weights.input_mean.setLinSpaced(-3, 5);
  weights.input_scale.setLinSpaced(80, 120);
  if (!is_traced) weights.output_mean.setLinSpaced(-1, 1);
  weights.output_scale.setLinSpaced(0.5, 2);
  int width = is_traced ? 6 * info.inputs : info.inputs;
  for (int layer = 0; layer < 2; ++layer, width = units) {
    const bool recurrent = IsRecurrent(architecture);
    const int rows = recurrent ? width + units : width, columns = recurrent ? 4 * units : units;
    const WeightMatrix kernel = WeightMatrix::NullaryExpr(rows, columns, number);
    const Eigen::VectorXf bias = Eigen::VectorXf::NullaryExpr(columns, number);
    if (recurrent) {
      weights.lstm.push_back({kernel, bias});
    } else {
      weights.dense.push_back({kernel, bias});
    }
  }
  weights.dense.push_back({WeightMatrix::NullaryExpr(width, info.outputs, number),
                           Eigen::VectorXf::NullaryExpr(info.outputs, number)});
  return made;
}

nlohmann::json JsonOf(const RandomNetwork& network) {
  using nlohmann::json;
  const auto numbers = [](const auto& values) {
    json list = json::array();
    for (const float value : values) list.push_back(static_cast<double>(value));
    return list;
  };
  const auto layers = [&](const auto& of_a_kind) {
    json list = json::array();
    for (const auto& layer : of_a_kind) {
      json rows = json::array();
      for (Eigen::Index i = 0; i < layer.kernel.rows(); ++i) {
        rows.push_back(numbers(Eigen::VectorXf(layer.kernel.row(i))));
      }
      list.push_back({{"kernel", rows}, {"bias", numbers(layer.bias)}});
    }
    return list;
  };
  const NetworkInfo& info = network.info;
  const NetworkWeights& weights = network.weights;
  return {
      {"palpate_force_network", 1},
      {"architecture", info.architecture},
      {"inputs", info.inputs},
      {"window", info.window},
      {"outputs", info.outputs},
      {"rate", info.rate},
      {"gain", info.gain},
      {"input", {{"mean", numbers(weights.input_mean)}, {"scale", numbers(weights.input_scale)}}},
      {"lstm", layers(weights.lstm)},
      {"dense", layers(weights.dense)},
      {"output",
       {{"mean", numbers(weights.output_mean)}, {"scale", numbers(weights.output_scale)}}}};
}

RandomNetwork AuthorsNetwork(const std::filesystem::path& dir) {
  std::ifstream stream(dir / "tensors.json");
  const auto root = nlohmann::json::parse(stream);
  const auto matrix = [&](const std::string& name) {
    const auto data = root.at(name).at("data").get<std::vector<float>>();
    const Eigen::Index rows = root.at(name).at("shape").at(0);
    return WeightMatrix(Eigen::Map<const WeightMatrix>(
        data.data(), rows, static_cast<Eigen::Index>(data.size()) / rows));
  };
  RandomNetwork network = MakeRandomNetwork("rnn_21", 20, 0, 1);
  network.info.gain = 1;
  network.weights.LeaveUnscaled(21, 4);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::string layer = "layer" + std::to_string(k + 1);
    const std::string cell = layer + "/" + layer + "/BasicLSTMCell/Linear/";
    network.weights.lstm[k] = {matrix(cell + "Matrix"), matrix(cell + "Bias").col(0)};
  }
  network.weights.dense = {{matrix("output_layer/W"), matrix("output_layer/b").col(0)}};
  return network;
}

std::vector<TactileSignals> RandomSignals(int count, float counts, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> phase(0, 6.28f), rate(0.01f, 0.3f), noise(-1, 1);
  TactileSignals phases{}, rates{};
  for (auto& x : phases) x = phase(random);
  for (auto& x : rates) x = rate(random);
  std::vector<TactileSignals> signals(static_cast<std::size_t>(count));
  for (std::size_t t = 0; t < signals.size(); ++t) {
    for (std::size_t i = 0; i < phases.size(); ++i) {
      const auto time = static_cast<TactileSignals::value_type>(t);
      const auto wave = std::sin(phases[i] + rates[i] * time);
      signals[t][i] = counts * (0.9f * wave + 0.1f * noise(random));
    }
  }
  return signals;
}

}  // namespace palpate
