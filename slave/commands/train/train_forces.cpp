#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "slave/commands/progress_bar.h"
#include "slave/commands/train/train_data.h"
#include "slave/tactile/network/network_file.h"
#include "slave/tactile/training/estimate_errors.h"
#include "slave/tactile/training/learn_pattern.h"

namespace palpate {
namespace {

// Windows that are still tested after a signal: a fraction of a second.
constexpr std::size_t kHastyTest = 10'000;

ForceTrainingOptions SettingsOf(const TrainOptions& options, const std::string& architecture) {
  ForceTrainingOptions settings = options.training;
  settings.architecture = architecture;
  settings.descent = options.optimiser == "sgd" ? ForceTrainingOptions::Descent::kSgd
                                                : ForceTrainingOptions::Descent::kAdam;
  settings.seed = static_cast<std::uint64_t>(options.seed);
  return settings;
}

// The contacts, and where they are tested.
struct Lesson {
  TrainingData data;
  Split split;
  [[nodiscard]] std::span<const LabelledRecording> test_recordings() const {
    return data.test.empty() ? data.data : data.test;
  }
};

Lesson Prepare(const TrainOptions& options) {
  Lesson lesson{ReadTrainingData(options), {}};
  for (const std::string& network : options.networks) {
    RequireSignals(lesson.data, network, InputsOf(network));
  }
  lesson.split = SplitContacts(lesson.data.data, !lesson.data.test.empty(), options.seed);
  for (std::size_t i = 0; i < lesson.data.test.size(); ++i) {
    const LabelledRecording& r = lesson.data.test[i];
    lesson.split.test.push_back({i, r.begin, r.end, r.begin});
  }
  if (WindowsOf(lesson.split.test, kNetworkWindow).empty()) {
    throw std::invalid_argument("too few samples for a test: no window of " +
                                std::to_string(kNetworkWindow) + " samples");
  }
  return lesson;
}

// Tells `learnt` how wrong it is, too.
ForceErrors Test(const Lesson& lesson, bool hasty, LearntForce* learnt) {
  std::vector<Window> windows = WindowsOf(lesson.split.test, kNetworkWindow);
  if (hasty) windows.resize(std::min(windows.size(), kHastyTest));
  const auto network = MakeForceNetwork(learnt->info, learnt->weights);
  const auto estimated = EstimateForces(*network, lesson.test_recordings(), windows);
  const auto measured = MeasuredForces(lesson.test_recordings(), windows);
  LearnErrors(lesson.test_recordings(), windows, estimated, measured, &learnt->info.pattern);
  const ForceErrors errors = CompareForces(estimated, measured);
  learnt->info.sigma = errors.rmse;
  learnt->info.rest_sigma = errors.at_rest;
  learnt->info.error = errors.law;
  return errors;
}

nlohmann::json Axes(const Eigen::Vector3d& values) {
  return {values.x(), values.y(), values.z()};  // what is not a number becomes null
}

std::string Summary(const TrainOptions& options, const Lesson& lesson, const LearntForce& learnt,
                    const ForceErrors* errors) {
  nlohmann::json summary = {
      {"data", NamesOf(options.data)},
      {"split", lesson.split.how},
      {"optimiser", options.optimiser},
      {"rate", options.training.rate},
      {"batch", options.training.batch},
      {"seed", options.seed},
      {"epochs", learnt.epochs.size()},
      {"best_epoch", learnt.best_epoch},
      {"stopped", learnt.stopped},
      {"train_windows", learnt.train_windows},
      {"validation_windows", learnt.validation_windows},
  };
  if (!options.test.empty()) summary["test"] = NamesOf(options.test);
  if (errors != nullptr) {
    summary["test_windows"] = errors->count;
    summary["test_rmse_N"] = Axes(errors->rmse);
    summary["test_smse"] = Axes(errors->smse);
    summary["test_correlation"] = Axes(errors->correlation);
  }
  return summary.dump();
}

std::string Origin(const TrainOptions& options, const std::string& architecture) {
  std::string origin =
      "palpate-slave train " + NamesOf(options.data) + " --network " + architecture;
  if (std::ranges::find(options.data, "simulated") != options.data.end()) {
    origin += " --presses " + std::to_string(options.presses);
  }
  return origin + " --epochs " + std::to_string(options.training.epochs) + " --seed " +
         std::to_string(options.seed);
}

TestedNetwork TrainOne(const TrainOptions& options, const std::string& architecture,
                       const std::filesystem::path& dir, const Lesson& lesson,
                       const std::stop_token& stop) {
  LearntForce learnt;
  {
    ProgressBar bar("train", stop);
    learnt = TrainForce(lesson.data.data, lesson.split, SettingsOf(options, architecture), bar);
  }
  learnt.info.origin = Origin(options, architecture);
  // First of all what was learnt is kept; the test may be interrupted.
  WriteForceNetwork(dir, learnt.info, learnt.weights, Summary(options, lesson, learnt, nullptr));
  WriteEpochs(dir / "training.csv", learnt.epochs);
  const TestedNetwork tested{architecture, Test(lesson, stop.stop_requested(), &learnt)};
  WriteForceNetwork(dir, learnt.info, learnt.weights,
                    Summary(options, lesson, learnt, &tested.errors));
  std::printf("%s: best of %zu epochs is %d%s, %s\n", architecture.c_str(), learnt.epochs.size(),
              learnt.best_epoch, learnt.stopped ? ", stopped" : "",
              AlongNormal(tested.errors).c_str());
  std::fflush(stdout);
  return tested;
}

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
    throw std::invalid_argument("too few samples: the network has a window of " +
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
      "more. Check the finger, the sensor, and that the slice has rest around its contacts",
      NamesOf(options.data), errors.correlation.z(), kLeastCorrelation));
}

}  // namespace

int TrainForceNetworks(const TrainOptions& options, const std::stop_token& stop) {
  const Lesson lesson = Prepare(options);
  std::printf("%s\n", lesson.split.how.c_str());
  std::fflush(stdout);
  std::vector<TestedNetwork> tested;
  for (const std::string& architecture : options.networks) {
    if (!tested.empty() && stop.stop_requested()) break;
    const auto dir = options.networks.size() == 1 ? options.out : options.out / architecture;
    tested.push_back(TrainOne(options, architecture, dir, lesson, stop));
  }
  std::fputs(ForceTable(tested).c_str(), stdout);
  return 0;
}

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
  std::printf("gain %.4f, trained up to %.3f N\nfitted on %s\n  %s\n", known.info.gain,
              known.info.learnt_force, NamesOf(options.data).c_str(), AlongNormal(own).c_str());
  ForceErrors tested = own;
  if (!data.test.empty()) {
    tested = errors(data.test);
    std::printf("tested on %s\n  %s\n", NamesOf(options.test).c_str(), AlongNormal(tested).c_str());
  }
  // Only the gain of fz is known to fit; the others' errors are not.
  known.info.sigma = {0, 0, tested.rmse.z()};
  known.info.rest_sigma = 0;
  known.info.error = {};
  for (SignalPattern::Kind& kind : known.info.pattern.kinds) kind.error = {};
  nlohmann::json training = nlohmann::json::parse(known.training);
  training["gain"] = {{"data", NamesOf(options.data)},
                      {"test", NamesOf(options.test)},
                      {"rmse_fz_N", tested.rmse.z()},
                      {"correlation_fz", tested.correlation.z()}};
  WriteForceNetwork(options.out, known.info, known.weights, training.dump());
  return 0;
}

}  // namespace palpate
