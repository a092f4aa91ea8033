#include "slave/tactile/training/batch_workers.h"

#include <algorithm>
#include <thread>

namespace palpate {
namespace {

constexpr std::size_t kChunk = 32;  // windows; what one keeps of all steps fits a core's cache

}  // namespace

BatchWorkers::BatchWorkers(const std::function<std::unique_ptr<BatchGradient>()>& make,
                           const ScaledWindows& windows, int threads)
    : windows_(windows) {
  for (int i = 0; i < threads; ++i) {
    Worker worker{make(), {}, {}};
    worker.inputs.resize(static_cast<std::size_t>(worker.network->steps()));
    workers_.push_back(std::move(worker));
  }
}

double BatchWorkers::Loss(const Eigen::VectorXf& weights, std::span<const Window> batch) {
  return Run(weights, batch, false);
}

double BatchWorkers::LossAndGradient(const Eigen::VectorXf& weights, std::span<const Window> batch,
                                     Eigen::VectorXf* gradient) {
  const double loss = Run(weights, batch, true);
  gradient->setZero(weights.size());
  for (std::size_t c = 0; c * kChunk < batch.size(); ++c) *gradient += chunks_[c].gradient;
  return loss;
}

double BatchWorkers::Run(const Eigen::VectorXf& weights, std::span<const Window> batch,
                         bool with_gradient) {
  const std::size_t count = (batch.size() + kChunk - 1) / kChunk;
  if (chunks_.size() < count) chunks_.resize(count);
  for (std::size_t c = 0; c < count; ++c) {
    chunks_[c].gradient.setZero(with_gradient ? weights.size() : 0);
  }
  const auto weight = static_cast<float>(2.0 / (3.0 * static_cast<double>(batch.size())));
  const auto work = [&](std::size_t first) {
    for (std::size_t c = first; c < count; c += workers_.size()) {
      const std::size_t at = c * kChunk;
      RunChunk(weights, batch.subspan(at, std::min(kChunk, batch.size() - at)), weight,
               &workers_[first], &chunks_[c]);
    }
  };
  {
    // A feed-forward batch is over before a thread has started.
    const bool alone = workers_.front().network->steps() == 1;
    std::vector<std::jthread> threads;
    for (std::size_t i = 1; !alone && i < std::min(workers_.size(), count); ++i) {
      threads.emplace_back(work, i);
    }
    work(0);
    for (std::size_t i = 1; alone && i < std::min(workers_.size(), count); ++i) work(i);
  }
  double squares = 0;
  for (std::size_t c = 0; c < count; ++c) squares += chunks_[c].squares;
  return squares / (3.0 * static_cast<double>(batch.size()));
}

void BatchWorkers::RunChunk(const Eigen::VectorXf& weights, std::span<const Window> windows,
                            float weight, Worker* worker, Chunk* chunk) const {
  windows_.Gather(windows, &worker->inputs, &worker->forces);
  // From here on `forces` holds the residual.
  worker->forces = worker->network->Forward(weights, worker->inputs) - worker->forces;
  chunk->squares = static_cast<double>(worker->forces.squaredNorm());
  if (chunk->gradient.size() == 0) return;
  worker->forces *= weight;
  worker->network->Backward(weights, worker->forces, &chunk->gradient);
}

}  // namespace palpate
