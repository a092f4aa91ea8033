#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "slave/commands/train/train_data.h"
#include "slave/commands/train/train_forces.h"
#include "slave/commands/train/train_words.h"
#include "slave/tactile/network/network_file.h"
#include "slave/tactile/training/estimate_errors.h"

namespace palpate {
namespace {

constexpr double kLeastForce = 1e-6;  // fz that varies by less does not vary [N]
constexpr double kLeastCorrelation = 0.5;

struct Comparison {
  std::vector<Eigen::Vector3f> estimated, measured;  // [N]
};

// At all wanted instants for which the network has a window; it may look back before them.
Comparison Compare(const ForceNetwork& network, std::span<const LabelledRecording> recordings) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < recordings.size(); ++i) {
    stretches.push_back({i, recordings[i].begin, recordings[i].end, 0});
  }
  const std::vector<Window> windows = WindowsOf(stretches, network.info().window);
  if (windows.empty()) {
    throw std::invalid_argument("too few samples: the network looks back over " +
                                std::to_string(network.info().window));
  }
  return {EstimateForces(network, recordings, windows), MeasuredForces(recordings, windows)};
}

// ONNX files keep no gain and are not accepted.
NetworkFile ReadKnown(const std::filesystem::path& from) {
  try {
    std::error_code unreadable;
    const bool own = std::filesystem::exists(from / kNetworkFileName, unreadable);
    return own ? ReadForceNetwork(from) : ImportTensors(from);
  } catch (const std::runtime_error& e) {
    throw std::invalid_argument("--from " + std::string(e.what()));
  }
}

void RefuseConstantForce(std::span<const LabelledRecording> recordings) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const LabelledRecording& r : recordings) {
    for (std::size_t i = r.begin; i < r.end; ++i) {
      least = std::fmin(least, static_cast<double>(r.force[i].z()));
      most = std::fmax(most, static_cast<double>(r.force[i].z()));
    }
  }
  if (most - least > kLeastForce) return;
  throw std::invalid_argument("fz is the same in all samples: no gain can be fitted to it");
}

// A gain makes forces larger or smaller; it does not make them others.
void RefuseUnlike(const ForceErrors& errors, const TrainOptions& options) {
  if (errors.correlation.z() >= kLeastCorrelation) return;
  throw std::invalid_argument(fmt::format(
      "{}: fz of the network and of the recording have correlation {:.2f}: accepted is {:g} or "
      "more. Another finger, another sensor, or a slice without rest around its presses?",
      NamesOf(options.data), errors.correlation.z(), kLeastCorrelation));
}

}  // namespace

int TrainForceGain(const TrainOptions& options) {
  NetworkFile known = ReadKnown(options.from);
  const TrainingData data = ReadTrainingData(options);
  RequireSignals(data, options.from.string(), known.info.inputs);
  RefuseConstantForce(data.data);
  known.info.gain = 1;
  const Comparison fit = Compare(*MakeForceNetwork(known.info, known.weights), data.data);
  known.info.gain = FitForceGain(fit.estimated, fit.measured);
  known.info.learnt_force = 0;
  for (const Eigen::Vector3f& f : fit.measured) {
    known.info.learnt_force = std::max(known.info.learnt_force, static_cast<double>(f.norm()));
  }

  const auto network = MakeForceNetwork(known.info, known.weights);
  const auto errors = [&](std::span<const LabelledRecording> recordings) {
    const Comparison c = Compare(*network, recordings);
    return CompareForces(c.estimated, c.measured);
  };
  const ForceErrors own = errors(data.data);
  RefuseUnlike(own, options);
  std::printf("gain %.4f, learnt up to %.3f N\nfitted on %s\n  %s\n", known.info.gain,
              known.info.learnt_force, NamesOf(options.data).c_str(), AlongNormal(own).c_str());
  ForceErrors tested = own;
  if (!data.test.empty()) {
    tested = errors(data.test);
    std::printf("tested on %s\n  %s\n", NamesOf(options.test).c_str(), AlongNormal(tested).c_str());
  }
  // Only the gain of fz is known to fit; the others' errors are not.
  known.info.sigma = {0, 0, tested.rmse.z()};
  nlohmann::json training = nlohmann::json::parse(known.training);
  training["gain"] = {{"data", NamesOf(options.data)},
                      {"test", NamesOf(options.test)},
                      {"rmse_fz_N", tested.rmse.z()},
                      {"correlation_fz", tested.correlation.z()}};
  WriteForceNetwork(options.out, known.info, known.weights, training.dump());
  return 0;
}

}  // namespace palpate
