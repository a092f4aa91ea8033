// A training step: windows of samples, loss and gradient of a batch on several threads, and the
// update of the weights.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/recordings/labelled_recording.h"
#include "slave/tactile/training/batch_gradient.h"

namespace palpate {

// Signals and forces are divided by these; the baseline, 0, stays 0. Errors of networks of traces
// are relative to the force, so that small forces are not neglected.
struct TrainingScales {
  Eigen::VectorXf signals;  // E1 to E19[, pac0, pdc] [counts]
  Eigen::Vector3f forces;   // [N]
  float gentle = 1;         // of forces below it errors count nearly alike [N]
  float weight = 1;         // normalises WeightOf to 1, rms over the windows

  // Of an error where the force is this one [N].
  [[nodiscard]] float WeightOf(const Eigen::Vector3f& force) const {
    return weight / (1 + force.norm() / gentle);
  }
};

// Their rms over the windows' last samples. A signal that hardly moves compared with its kind
// (electrodes; pac; pdc) is noise and must not be blown up: at least a quarter of the kind's rms;
// in the same way for axes of force, a tenth of the largest.
// Throws std::invalid_argument: all electrodes, or all forces, are constant or not finite.
TrainingScales ScalesOf(std::span<const LabelledRecording> recordings,
                        std::span<const Window> windows, int inputs);

// Network input of a window.
enum class Reading : std::uint8_t {
  kSignals,  // the signals of its samples
  kTraces,   // the features of SignalTraces at its last sample, decorrelated by mix()
};

class ScaledWindows {
 public:
  ScaledWindows(std::span<const LabelledRecording> recordings, const TrainingScales& scales,
                Reading reading = Reading::kSignals);

  // Inputs are mix() x for features x; symmetric. For signals: empty.
  [[nodiscard]] const Eigen::MatrixXf& mix() const { return mix_; }

  // Fills `batch` (one matrix windows x inputs per step, the last one the present), `forces`
  // (windows x 3) and `weights` of their errors.
  void Gather(std::span<const Window> windows, std::vector<Eigen::MatrixXf>* batch,
              Eigen::MatrixXf* forces, Eigen::VectorXf* weights) const;

 private:
  void ReplaceElectrodes();
  void TakeTraces();
  void Mix();

  Eigen::MatrixXf mix_;
  std::vector<Eigen::MatrixXf> signals_;  // per recording, inputs x samples
  std::vector<Eigen::MatrixXf> forces_;   // per recording, 3 x samples
  std::vector<Eigen::VectorXf> weights_;  // per recording, of each sample
};

// Cuts batches into chunks of a fixed size and adds their results in order: the sum does not depend
// on the number of threads.
class BatchWorkers {
 public:
  // `make`: called once per thread. `windows` is only referred to.
  BatchWorkers(const std::function<std::unique_ptr<BatchGradient>()>& make,
               const ScaledWindows& windows, int threads);

  // Mean squared error over windows and axes, weighted.
  double Loss(const Eigen::VectorXf& weights, std::span<const Window> batch);
  // The same, and its gradient.
  double LossAndGradient(const Eigen::VectorXf& weights, std::span<const Window> batch,
                         Eigen::VectorXf* gradient);

 private:
  struct Worker {
    std::unique_ptr<BatchGradient> network;
    std::vector<Eigen::MatrixXf> inputs;
    Eigen::MatrixXf forces;
    Eigen::VectorXf weights;  // of the forces' errors
  };
  struct Chunk {
    double squares = 0;
    Eigen::VectorXf gradient;
  };
  double Run(const Eigen::VectorXf& weights, std::span<const Window> batch, bool with_gradient);
  void RunChunk(const Eigen::VectorXf& weights, std::span<const Window> windows, float weight,
                Worker* worker, Chunk* chunk) const;

  const ScaledWindows& windows_;
  std::vector<Worker> workers_;
  std::vector<Chunk> chunks_;
};

// How a gradient changes the weights.
class Optimiser {
 public:
  virtual ~Optimiser() = default;
  Optimiser() = default;
  Optimiser(const Optimiser&) = delete;
  Optimiser& operator=(const Optimiser&) = delete;
  // `rate`: of this step; schedules are the caller's.
  virtual void Step(double rate, const Eigen::VectorXf& gradient, Eigen::VectorXf* weights) = 0;
};

// weights -= rate * gradient: the paper's.
std::unique_ptr<Optimiser> MakeSgd();
// Adam (Kingma and Ba 2015) with its usual constants 0.9, 0.999, 1e-8.
std::unique_ptr<Optimiser> MakeAdam(Eigen::Index weights);

}  // namespace palpate
