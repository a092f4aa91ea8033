#include "slave/tactile/training/force_trainer.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <random>
#include <stdexcept>

#include <fmt/format.h>

#include "slave/tactile/network/signal_traces.h"
#include "slave/tactile/training/batch_gradient.h"
#include "slave/tactile/training/batch_workers.h"
#include "slave/tactile/training/learn_pattern.h"

namespace palpate {
namespace {

using Descent = ForceTrainingOptions::Descent;

constexpr std::size_t kFewestWindows = 100;    // one second of samples
constexpr std::size_t kMostValidation = 4096;  // windows looked at after every epoch
constexpr float kLargestGradient = 5;          // longer ones are cut to this length
constexpr std::size_t kTracedPasses = 8;
constexpr double kSgdRate = 0.01, kAdamRate = 4e-3;

void Accept(bool good, const char* what, double value, const char* accepted) {
  if (good) return;
  throw std::invalid_argument(fmt::format("{} {:g}: accepted is {}", what, value, accepted));
}

void Check(const ForceTrainingOptions& o) {
  if (InputsOf(o.architecture) == 0) {
    throw std::invalid_argument("network " + o.architecture + ": accepted is " +
                                std::string(kArchitectures));
  }
  Accept(o.rate >= 0 && o.rate <= 1, "rate", o.rate, "0 < rate <= 1, or 0 for the optimiser's own");
  Accept(o.epochs >= 1, "epochs", o.epochs, "1 or more");
  Accept(o.patience >= 1, "patience", o.patience, "1 or more");
  Accept(o.batch >= 1, "batch", o.batch, "1 or more");
  Accept(o.epoch_size >= 1, "epoch size", o.epoch_size, "1 or more");
  Accept(o.threads >= 1 && o.threads <= 256, "threads", o.threads, "1 to 256");
}

std::unique_ptr<BatchGradient> MakeGradient(const std::string& architecture) {
  const int inputs = InputsOf(architecture);
  if (IsRecurrent(architecture)) return MakeLstmGradient(inputs, kLstmUnits, kNetworkWindow);
  if (IsTraced(architecture)) {
    return MakeDenseGradient(static_cast<int>(FeatureCount(inputs)), {kTraceUnits, kTraceUnits});
  }
  return MakeDenseGradient(inputs, {kDenseUnits, kDenseUnits});
}

// Windows in a shuffled order, from the start again when all have been drawn.
class Deck {
 public:
  Deck(std::vector<Window> windows, std::uint64_t seed)
      : windows_(std::move(windows)), random_(seed) {
    Shuffle();
  }
  // Up to `count`; fewer at the end of a pass.
  std::span<const Window> Draw(std::size_t count) {
    if (at_ == windows_.size()) Shuffle();
    const std::size_t from = at_;
    at_ = std::min(at_ + count, windows_.size());
    return std::span(windows_).subspan(from, at_ - from);
  }

 private:
  void Shuffle() {
    for (std::size_t i = windows_.size(); i > 1; --i) {
      std::swap(windows_[i - 1], windows_[random_() % i]);
    }
    at_ = 0;
  }
  std::vector<Window> windows_;
  std::mt19937_64 random_;
  std::size_t at_ = 0;
};

std::vector<Window> Thinned(const std::vector<Window>& windows, std::size_t most) {
  const std::size_t stride = (windows.size() + most - 1) / most;
  std::vector<Window> kept;
  for (std::size_t i = 0; i < windows.size(); i += stride) kept.push_back(windows[i]);
  return kept;
}

double RateAt(const ForceTrainingOptions& options, double done) {
  if (options.descent == Descent::kSgd) return options.rate > 0 ? options.rate : kSgdRate;
  const double rate = options.rate > 0 ? options.rate : kAdamRate;
  return rate * 0.5 * (1 + std::cos(std::numbers::pi * done));
}

// A window of traces costs a fiftieth of what one of samples does.
std::size_t EpochSize(const ForceTrainingOptions& options) {
  const auto size = static_cast<std::size_t>(options.epoch_size);
  return IsTraced(options.architecture) ? kTracedPasses * size : size;
}

// One run of training.
class Descender {
 public:
  Descender(const ScaledWindows& scaled, const ForceTrainingOptions& options,
            std::vector<Window> train, std::vector<Window> validation, Progress* progress)
      : options_(options),
        progress_(progress),
        workers_([&] { return MakeGradient(options.architecture); }, scaled, options.threads),
        per_epoch_(std::min(train.size(), EpochSize(options))),
        deck_(std::move(train), options.seed),
        validation_(Thinned(validation, kMostValidation)) {
    const std::unique_ptr<BatchGradient> network = MakeGradient(options.architecture);
    weights_ = network->Initial(options.seed);
    optimiser_ = options.descent == Descent::kSgd ? MakeSgd() : MakeAdam(weights_.size());
  }

  void Run(LearntForce* learnt) {
    double best = 0;
    for (int epoch = 1; epoch <= options_.epochs; ++epoch) {
      TrainingEpoch record{epoch, 0, 0};
      if (!RunEpoch(&record)) {
        learnt->stopped = true;
        break;
      }
      record.validation_loss = workers_.Loss(weights_, validation_);
      learnt->epochs.push_back(record);
      if (epoch == 1 || record.validation_loss < best) {
        best = record.validation_loss;
        learnt->best_epoch = epoch;
        best_weights_ = weights_;
      }
      if (epoch - learnt->best_epoch >= options_.patience) break;
    }
    if (learnt->best_epoch == 0) throw Interrupted();
    MakeGradient(options_.architecture)->FillLayers(best_weights_, &learnt->weights);
  }

 private:
  // False: stopped.
  bool RunEpoch(TrainingEpoch* record) {
    std::size_t seen = 0;
    while (seen < per_epoch_) {
      const double done =
          (record->epoch - 1 + static_cast<double>(seen) / static_cast<double>(per_epoch_)) /
          options_.epochs;
      if (!progress_->Report(options_.architecture, done)) return false;
      const auto wanted = std::min(static_cast<std::size_t>(options_.batch), per_epoch_ - seen);
      const std::span<const Window> batch = deck_.Draw(wanted);
      const double loss = workers_.LossAndGradient(weights_, batch, &gradient_);
      const float length = gradient_.norm();
      if (length > kLargestGradient) gradient_ *= kLargestGradient / length;
      optimiser_->Step(RateAt(options_, done), gradient_, &weights_);
      record->loss += loss * static_cast<double>(batch.size()) / static_cast<double>(per_epoch_);
      seen += batch.size();
    }
    return true;
  }

  const ForceTrainingOptions& options_;
  Progress* progress_;
  BatchWorkers workers_;
  std::size_t per_epoch_;
  Deck deck_;
  std::vector<Window> validation_;
  std::unique_ptr<Optimiser> optimiser_;
  Eigen::VectorXf weights_, best_weights_, gradient_;
};

void CheckWindows(const char* part, std::size_t windows, std::size_t fewest) {
  if (windows >= fewest) return;
  throw std::invalid_argument("too few samples: " + std::to_string(windows) + " windows of " +
                              std::to_string(kNetworkWindow) + " samples for " + part +
                              ", needed are " + std::to_string(fewest));
}

}  // namespace

LearntForce TrainForce(std::span<const LabelledRecording> recordings, const Split& split,
                       const ForceTrainingOptions& options, Progress& progress) {
  Check(options);
  // Feed-forward networks learn from the same instants, so that figures can be compared.
  std::vector<Window> train = WindowsOf(split.train, kNetworkWindow);
  std::vector<Window> validation = WindowsOf(split.validation, kNetworkWindow);
  CheckWindows("training", train.size(), kFewestWindows);
  CheckWindows("validation", validation.size(), kFewestWindows / 10);
  const int inputs = InputsOf(options.architecture);
  const TrainingScales scales = ScalesOf(recordings, train, inputs);

  LearntForce learnt;
  learnt.train_windows = train.size();
  learnt.validation_windows = validation.size();
  learnt.info.architecture = options.architecture;
  learnt.info.inputs = inputs;
  const bool is_traced = IsTraced(options.architecture);
  const bool looks_back = IsRecurrent(options.architecture) || is_traced;
  learnt.info.window = looks_back ? kNetworkWindow : 1;
  learnt.info.outputs = 3;
  learnt.info.rate = kNetworkRate;
  learnt.info.pattern = LearnPattern(recordings, train);
  for (const Window& w : train) {
    learnt.info.learnt_force =
        std::max(learnt.info.learnt_force,
                 static_cast<double>(recordings[w.recording].force[w.last].norm()));
  }
  learnt.weights.LeaveUnscaled(inputs, 3);
  learnt.weights.input_scale = scales.signals;
  learnt.weights.output_scale = scales.forces;
  const ScaledWindows scaled(recordings, scales, is_traced ? Reading::kTraces : Reading::kSignals);
  Descender(scaled, options, std::move(train), std::move(validation), &progress).Run(&learnt);
  if (is_traced) {
    DenseLayer& first = learnt.weights.dense.front();
    first.kernel = scaled.mix() * Eigen::MatrixXf(first.kernel);
  }
  return learnt;
}

}  // namespace palpate
