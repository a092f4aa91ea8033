#include "slave/tactile/training/batch_workers.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

#include <Eigen/LU>

#include "shared/geometry/symmetric_eigen.h"
#include "slave/tactile/network/signal_traces.h"

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::MatrixXf;
using Eigen::VectorXf;

constexpr float kQuietSignal = 0.25F;  // of its kind's rms
constexpr float kQuietAxis = 0.1F;     // of the largest axis

constexpr float kGentle = 0.02F;       // of the largest force
constexpr double kLeastApart = 1e-4;   // of signals' variance, about 1
constexpr double kLeastUnlike = 1e-4;  // of features' variance, about 1

constexpr std::size_t kChunk = 32;  // windows; what one keeps of all steps fits a core's cache

class Sgd final : public Optimiser {
 public:
  void Step(double rate, const VectorXf& gradient, VectorXf* weights) override {
    *weights -= static_cast<float>(rate) * gradient;
  }
};

class Adam final : public Optimiser {
 public:
  explicit Adam(Eigen::Index weights)
      : mean_(VectorXf::Zero(weights)), square_(VectorXf::Zero(weights)) {}

  void Step(double rate, const VectorXf& gradient, VectorXf* weights) override {
    ++steps_;
    mean_ = kMeanDecay * mean_ + (1 - kMeanDecay) * gradient;
    square_ = kSquareDecay * square_ + (1 - kSquareDecay) * gradient.cwiseAbs2();
    // Both averages start at zero: early ones are raised to what they stand for.
    const double mean_share = 1 - std::pow(static_cast<double>(kMeanDecay), steps_);
    const double square_share = 1 - std::pow(static_cast<double>(kSquareDecay), steps_);
    const auto step = static_cast<float>(rate / mean_share);
    const auto raise = static_cast<float>(1 / square_share);
    weights->array() -= step * mean_.array() / ((raise * square_.array()).sqrt() + kFloor);
  }

 private:
  static constexpr float kMeanDecay = 0.9F, kSquareDecay = 0.999F, kFloor = 1e-8F;
  int steps_ = 0;
  VectorXf mean_, square_;
};

void WeighErrors(std::span<const LabelledRecording> recordings, std::span<const Window> windows,
                 TrainingScales* scales) {
  float largest = 0;
  const auto force = [&](const Window& w) { return recordings[w.recording].force[w.last]; };
  for (const Window& w : windows) largest = std::max(largest, force(w).norm());
  scales->gentle = kGentle * largest;
  double squares = 0;
  for (const Window& w : windows) {
    squares += std::pow(static_cast<double>(scales->WeightOf(force(w))), 2);
  }
  scales->weight = static_cast<float>(std::sqrt(static_cast<double>(windows.size()) / squares));
}

// Mean of x x' over all columns, with `floor` more of each variance.
Eigen::MatrixXd Covariance(const std::vector<MatrixXf>& columns, double floor) {
  const Index size = columns.front().rows();
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
  Index count = 0;
  for (const MatrixXf& x : columns) {
    sum += (x * x.transpose()).cast<double>();
    count += x.cols();
  }
  return sum / static_cast<double>(count) + floor * Eigen::MatrixXd::Identity(size, size);
}

}  // namespace

TrainingScales ScalesOf(std::span<const LabelledRecording> recordings,
                        std::span<const Window> windows, int inputs) {
  Eigen::VectorXd signals = Eigen::VectorXd::Zero(kSignalCount);
  Eigen::Vector3d forces = Eigen::Vector3d::Zero(), mean = forces;
  for (const Window& w : windows) {
    const LabelledRecording& r = recordings[w.recording];
    signals += Eigen::Map<const Eigen::VectorXd>(r.change[w.last].data(), kSignalCount).cwiseAbs2();
    forces += r.force[w.last].cast<double>().cwiseAbs2();
    mean += r.force[w.last].cast<double>();
  }
  const double count = std::max<double>(1, static_cast<double>(windows.size()));
  const Eigen::VectorXf rms = (signals / count).cwiseSqrt().cast<float>();
  const Eigen::Vector3d variance = forces / count - (mean / count).cwiseAbs2();
  if (!rms.allFinite() || !forces.allFinite()) {
    throw std::invalid_argument("signals or forces are not finite");
  }
  if (!(variance.sum() > 1e-12 * forces.sum() / count)) {
    throw std::invalid_argument("the force is the same in all training samples");
  }
  const float electrodes = rms.head(kElectrodeCount).norm() / std::sqrt(float{kElectrodeCount});
  if (!(electrodes > 0)) {
    throw std::invalid_argument("the electrodes are constant in all training samples");
  }
  TrainingScales scales;
  scales.signals = rms.head(inputs);
  scales.signals.head(kElectrodeCount) =
      scales.signals.head(kElectrodeCount).cwiseMax(kQuietSignal * electrodes);
  for (Index i = kElectrodeCount; i < inputs; ++i) {
    if (!(scales.signals[i] > 0)) scales.signals[i] = 1;  // not recorded, or always at rest
  }
  const Eigen::Vector3f force_rms = (forces / count).cwiseSqrt().cast<float>();
  scales.forces = force_rms.cwiseMax(kQuietAxis * force_rms.maxCoeff());
  WeighErrors(recordings, windows, &scales);
  return scales;
}

ScaledWindows::ScaledWindows(std::span<const LabelledRecording> recordings,
                             const TrainingScales& scales, Reading reading) {
  for (const LabelledRecording& r : recordings) {
    const auto samples = static_cast<Index>(r.change.size());
    MatrixXf signals(scales.signals.size(), samples), forces(3, samples);
    VectorXf weights(samples);
    for (Index i = 0; i < samples; ++i) {
      const auto at = static_cast<std::size_t>(i);
      signals.col(i) = Eigen::Map<const Eigen::VectorXd>(r.change[at].data(), scales.signals.size())
                           .cast<float>()
                           .cwiseQuotient(scales.signals);
      forces.col(i) = r.force[at].cwiseQuotient(scales.forces);
      weights[i] = reading == Reading::kTraces ? scales.WeightOf(r.force[at]) : 1;
    }
    weights_.push_back(std::move(weights));
    signals_.push_back(std::move(signals));
    forces_.push_back(std::move(forces));
  }
  if (reading == Reading::kSignals) return;
  ReplaceElectrodes();
  TakeTraces();
  Mix();
}

// In every other recording one electrode, in turn, is what the other signals let expect: networks
// are given that for one that is stuck, and must not hang on any.
void ScaledWindows::ReplaceElectrodes() {
  const Eigen::MatrixXf precision =
      Covariance(signals_, kLeastApart).inverse().eval().cast<float>();
  for (std::size_t k = 1; k < signals_.size(); k += 2) {
    const auto e = static_cast<Index>(k / 2 % kElectrodeCount);
    Eigen::RowVectorXf shares = -precision.row(e) / precision(e, e);
    shares[e] = 0;
    signals_[k].row(e) = (shares * signals_[k]).eval();
  }
}

// Forces in parts of the same size as the features, and their errors so many times as heavy.
void ScaledWindows::TakeTraces() {
  for (std::size_t k = 0; k < signals_.size(); ++k) {
    SignalTraces traces(signals_[k].rows(), kNetworkRate);
    MatrixXf features(FeatureCount(signals_[k].rows()), signals_[k].cols());
    for (Index i = 0; i < features.cols(); ++i) {
      const float size = traces.Take(signals_[k].col(i), features.col(i));
      forces_[k].col(i) /= size;
      weights_[k][i] *= size;
    }
    signals_[k] = std::move(features);
  }
}

// A sample and its running means are nearly the same, electrodes side by side too: what tells them
// apart would be learnt last.
void ScaledWindows::Mix() {
  const SymmetricEigen axes = EigenOf(Covariance(signals_, kLeastUnlike));
  const Eigen::VectorXd gains = axes.values.array().rsqrt();
  const Eigen::MatrixXd& V = axes.vectors;
  mix_ = (V * gains.asDiagonal() * V.transpose()).cast<float>();
  for (MatrixXf& signals : signals_) signals = (mix_ * signals).eval();
}

void ScaledWindows::Gather(std::span<const Window> windows, std::vector<MatrixXf>* batch,
                           MatrixXf* forces, VectorXf* weights) const {
  const auto steps = static_cast<Index>(batch->size());
  const auto rows = static_cast<Index>(windows.size());
  for (MatrixXf& step : *batch) step.resize(rows, signals_.front().rows());
  forces->resize(rows, 3);
  weights->resize(rows);
  for (Index row = 0; row < rows; ++row) {
    const Window& w = windows[static_cast<std::size_t>(row)];
    const auto last = static_cast<Index>(w.last);
    for (Index t = 0; t < steps; ++t) {
      (*batch)[static_cast<std::size_t>(t)].row(row) =
          signals_[w.recording].col(last - steps + 1 + t).transpose();
    }
    forces->row(row) = forces_[w.recording].col(last).transpose();
    (*weights)[row] = weights_[w.recording][last];
  }
}

BatchWorkers::BatchWorkers(const std::function<std::unique_ptr<BatchGradient>()>& make,
                           const ScaledWindows& windows, int threads)
    : windows_(windows) {
  for (int i = 0; i < threads; ++i) {
    Worker worker{make(), {}, {}, {}};
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
  windows_.Gather(windows, &worker->inputs, &worker->forces, &worker->weights);
  const auto counts = worker->weights.asDiagonal();
  // From here on `forces` holds the weighted residual.
  worker->forces =
      counts * (worker->network->Forward(weights, worker->inputs) - worker->forces).eval();
  chunk->squares = static_cast<double>(worker->forces.squaredNorm());
  if (chunk->gradient.size() == 0) return;
  worker->forces = weight * (counts * worker->forces).eval();
  worker->network->Backward(weights, worker->forces, &chunk->gradient);
}

std::unique_ptr<Optimiser> MakeSgd() {
  return std::make_unique<Sgd>();
}

std::unique_ptr<Optimiser> MakeAdam(Eigen::Index weights) {
  return std::make_unique<Adam>(weights);
}

}  // namespace palpate
