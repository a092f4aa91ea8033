// Loss and gradient of a batch on several threads.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "slave/tactile/training/batch_gradient.h"
#include "slave/tactile/training/scaled_windows.h"

namespace palpate {

// Cuts batches into chunks of a fixed size and adds what they give in their order: the sum does not
// depend on the number of threads.
class BatchWorkers {
 public:
  // `make`: called once per thread. `windows` is only referred to.
  BatchWorkers(const std::function<std::unique_ptr<BatchGradient>()>& make,
               const ScaledWindows& windows, int threads);

  // Mean squared error over windows and axes.
  double Loss(const Eigen::VectorXf& weights, std::span<const Window> batch);
  // The same, and its gradient.
  double LossAndGradient(const Eigen::VectorXf& weights, std::span<const Window> batch,
                         Eigen::VectorXf* gradient);

 private:
  struct Worker {
    std::unique_ptr<BatchGradient> network;
    std::vector<Eigen::MatrixXf> inputs;
    Eigen::MatrixXf forces;
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

}  // namespace palpate
