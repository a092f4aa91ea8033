#include "slave/tactile/network/network_weights.h"

#include <cmath>

#include "slave/scene/units.h"
#include "slave/tactile/network/signal_traces.h"

namespace palpate {
namespace {

constexpr int kMaxWindow = 1000;
constexpr Eigen::Index kMaxWidth = 1024;

std::string Shape(Eigen::Index rows, Eigen::Index columns) {
  return std::to_string(rows) + " x " + std::to_string(columns);
}

std::string FaultOfVector(const std::string& name, const Eigen::VectorXf& vector,
                          Eigen::Index expected) {
  if (vector.size() != expected) {
    return name + " has " + std::to_string(vector.size()) + " numbers, expected " +
           std::to_string(expected);
  }
  return vector.allFinite() ? "" : name + " contains a number that is not finite";
}

std::string FaultOfKernel(const std::string& name, const WeightMatrix& kernel, Eigen::Index rows,
                          Eigen::Index columns) {
  if (kernel.rows() != rows || kernel.cols() != columns) {
    return name + " is " + Shape(kernel.rows(), kernel.cols()) + ", expected " +
           Shape(rows, columns);
  }
  return kernel.allFinite() ? "" : name + " contains a number that is not finite";
}

std::string FaultOfScale(const std::string& name, const Eigen::VectorXf& mean,
                         const Eigen::VectorXf& scale, Eigen::Index expected) {
  std::string fault = FaultOfVector(name + ".mean", mean, expected);
  if (fault.empty()) fault = FaultOfVector(name + ".scale", scale, expected);
  if (fault.empty() && (scale.array() == 0).any()) fault = name + ".scale contains a 0";
  return fault;
}

std::string FaultOfInfo(const NetworkInfo& info) {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  const bool are_electrodes = info.channels.are_electrodes();
  const int inputs = InputsOf(info.architecture, are_electrodes);
  if (inputs == 0) {
    return "architecture = " + info.architecture + ": expected " +
           (are_electrodes ? std::string(kArchitectures)
                           : "rnn_N, dnn_N, tnn_N or qnn_N for N channels, 1 to " +
                                 std::to_string(kMaxChannels));
  }
  if (info.inputs != inputs) {
    return "inputs = " + std::to_string(info.inputs) + ": " + info.architecture + " has " +
           std::to_string(inputs);
  }
  const bool looks_back = IsRecurrent(info.architecture) || IsTraced(info.architecture);
  const int most = looks_back ? kMaxWindow : 1;
  if (info.window < 1 || info.window > most) {
    return "window = " + std::to_string(info.window) + ": expected 1" +
           (most > 1 ? " to " + std::to_string(most) : "") + " for " + info.architecture;
  }
  if (info.outputs < 3 || info.outputs > kMaxWidth) {
    return "outputs = " + std::to_string(info.outputs) + ": expected 3 to " +
           std::to_string(kMaxWidth) + " (fx, fy, fz first)";
  }
  if (info.gives_contact_point && info.outputs < 6) {
    return "outputs = " + std::to_string(info.outputs) + ": expected 6 or more with contact_point";
  }
  if (!are_electrodes && info.pattern.known()) return "pattern: expected none, it is of electrodes";
  if (!positive(info.noise)) return "noise is not a positive number";
  if (!positive(info.rate)) return "rate is not a positive number";
  if (!std::isfinite(info.gain) || info.gain == 0) return "gain is 0 or not a number";
  if (!info.sigma.allFinite() || (info.sigma.array() < 0).any())
    return "sigma is not three standard deviations";
  if (!std::isfinite(info.learnt_force) || info.learnt_force < 0)
    return "learnt_force is not a force";
  return "";
}

// Checks that the input width of each layer is the output width of the previous one.
class LayerCheck {
 public:
  explicit LayerCheck(Eigen::Index inputs) : width_(inputs) {}

  std::string Recurrent(const std::string& name, const LstmLayer& layer) {
    const Eigen::Index n = layer.units();
    if (n < 1 || n > kMaxWidth) {
      return name + ".kernel has " + std::to_string(layer.kernel.cols()) +
             " columns, expected 4 for each of 1 to " + std::to_string(kMaxWidth) + " units";
    }
    std::string fault = FaultOfKernel(name + ".kernel", layer.kernel, width_ + n, 4 * n);
    if (fault.empty()) fault = FaultOfVector(name + ".bias", layer.bias, 4 * n);
    width_ = n;
    return fault;
  }
  std::string Dense(const std::string& name, const DenseLayer& layer, bool last, int outputs) {
    const Eigen::Index n = last ? outputs : layer.kernel.cols();
    if (n < 1 || n > kMaxWidth) {
      return name + ".kernel has " + std::to_string(n) + " columns, expected 1 to " +
             std::to_string(kMaxWidth);
    }
    std::string fault = FaultOfKernel(name + ".kernel", layer.kernel, width_, n);
    if (fault.empty()) fault = FaultOfVector(name + ".bias", layer.bias, n);
    width_ = n;
    return fault;
  }

 private:
  Eigen::Index width_;
};

}  // namespace

void NetworkWeights::LeaveUnscaled(int inputs, int outputs) {
  input_mean = Eigen::VectorXf::Zero(inputs);
  input_scale = Eigen::VectorXf::Ones(inputs);
  output_mean = Eigen::VectorXf::Zero(outputs);
  output_scale = Eigen::VectorXf::Ones(outputs);
}

int InputsOf(std::string_view architecture, bool are_electrodes) {
  const std::string_view kind = architecture.substr(0, 4);
  const bool is_quadratic = IsQuadratic(architecture);
  if (kind != "rnn_" && kind != "dnn_" && kind != "tnn_" && !is_quadratic) return 0;
  if (are_electrodes && is_quadratic) return 0;
  const auto inputs = ParseInteger(architecture.substr(4));
  const bool is_known =
      inputs && (are_electrodes ? *inputs == kElectrodeCount || *inputs == kSignalCount
                                : *inputs >= 1 && *inputs <= kMaxChannels);
  return is_known ? static_cast<int>(*inputs) : 0;
}

bool IsRecurrent(std::string_view architecture) {
  return architecture.substr(0, 4) == "rnn_";
}

bool IsTraced(std::string_view architecture) {
  return architecture.substr(0, 4) == "tnn_";
}

bool IsQuadratic(std::string_view architecture) {
  return architecture.substr(0, 4) == "qnn_";
}

Eigen::Index FeaturesOf(const NetworkInfo& info) {
  if (IsTraced(info.architecture)) return FeatureCount(info.inputs);
  return IsQuadratic(info.architecture) ? 3 * info.inputs : info.inputs;
}

std::string FaultOf(const NetworkInfo& info, const NetworkWeights& weights) {
  std::string fault = FaultOfInfo(info);
  if (!fault.empty()) return fault;
  if (IsRecurrent(info.architecture) == weights.lstm.empty()) {
    return info.architecture +
           (weights.lstm.empty() ? ": expected lstm layers" : " must have no lstm layer");
  }
  if (weights.dense.empty()) return "there is no dense layer that gives the outputs";
  fault = FaultOfScale("input", weights.input_mean, weights.input_scale, info.inputs);
  const bool is_traced = IsTraced(info.architecture);
  const auto signs = [](const Eigen::VectorXf& v) { return (v.array() < 0).any(); };
  const auto is_set = [](const Eigen::VectorXf& v) { return (v.array() != 0).any(); };
  if (fault.empty() && is_traced &&
      (signs(weights.input_scale) || is_set(weights.input_mean) || is_set(weights.output_mean))) {
    return info.architecture + ": expected input.scale > 0 and means of 0";
  }
  LayerCheck check(FeaturesOf(info));
  for (std::size_t k = 0; k < weights.lstm.size() && fault.empty(); ++k) {
    fault = check.Recurrent("lstm[" + std::to_string(k) + "]", weights.lstm[k]);
  }
  for (std::size_t k = 0; k < weights.dense.size() && fault.empty(); ++k) {
    fault = check.Dense("dense[" + std::to_string(k) + "]", weights.dense[k],
                        k + 1 == weights.dense.size(), info.outputs);
  }
  if (!fault.empty()) return fault;
  return FaultOfScale("output", weights.output_mean, weights.output_scale, info.outputs);
}

}  // namespace palpate
