#include "slave/commands/train/train_forces.h"

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "slave/commands/progress_bar.h"
#include "slave/commands/train/train_data.h"
#include "slave/commands/train/train_words.h"
#include "slave/tactile/network/network_file.h"
#include "slave/tactile/training/estimate_errors.h"

namespace palpate {
namespace {

// Windows that are still tested after a signal: a fraction of a second.
constexpr std::size_t kHastyTest = 10'000;

ForceTrainingOptions SettingsOf(const TrainOptions& options, const std::string& architecture) {
  ForceTrainingOptions settings;
  settings.architecture = architecture;
  settings.descent = options.optimiser == "sgd" ? ForceTrainingOptions::Descent::kSgd
                                                : ForceTrainingOptions::Descent::kAdam;
  settings.rate = options.rate;
  settings.epochs = options.epochs;
  settings.patience = options.patience;
  settings.batch = options.batch;
  settings.seed = options.seed;
  settings.threads = options.threads;
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

ForceErrors Test(const LearntForce& learnt, const Lesson& lesson, bool hasty) {
  std::vector<Window> windows = WindowsOf(lesson.split.test, kNetworkWindow);
  if (hasty) windows.resize(std::min(windows.size(), kHastyTest));
  const auto network = MakeForceNetwork(learnt.info, learnt.weights);
  return CompareForces(EstimateForces(*network, lesson.test_recordings(), windows),
                       MeasuredForces(lesson.test_recordings(), windows));
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
      {"rate", options.rate},
      {"batch", options.batch},
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
  return origin + " --epochs " + std::to_string(options.epochs) + " --seed " +
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
  const TestedNetwork tested{architecture, Test(learnt, lesson, stop.stop_requested())};
  learnt.info.sigma = tested.errors.rmse;
  WriteForceNetwork(dir, learnt.info, learnt.weights,
                    Summary(options, lesson, learnt, &tested.errors));
  std::printf("%s: best of %zu epochs is %d%s, %s\n", architecture.c_str(), learnt.epochs.size(),
              learnt.best_epoch, learnt.stopped ? ", stopped" : "",
              AlongNormal(tested.errors).c_str());
  std::fflush(stdout);
  return tested;
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

}  // namespace palpate
