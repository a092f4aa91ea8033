#include "slave/tactile/training/scaled_windows.h"

#include <algorithm>
#include <stdexcept>

namespace palpate {
namespace {

using Eigen::Index;
using Eigen::MatrixXf;

constexpr float kQuietSignal = 0.25F;  // of its kind's rms
constexpr float kQuietAxis = 0.1F;     // of the largest axis

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
    throw std::invalid_argument("the force is the same in all training samples: nothing to learn");
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
  return scales;
}

ScaledWindows::ScaledWindows(std::span<const LabelledRecording> recordings,
                             const TrainingScales& scales) {
  for (const LabelledRecording& r : recordings) {
    const auto samples = static_cast<Index>(r.change.size());
    MatrixXf signals(scales.signals.size(), samples), forces(3, samples);
    for (Index i = 0; i < samples; ++i) {
      const auto at = static_cast<std::size_t>(i);
      signals.col(i) = Eigen::Map<const Eigen::VectorXd>(r.change[at].data(), scales.signals.size())
                           .cast<float>()
                           .cwiseQuotient(scales.signals);
      forces.col(i) = r.force[at].cwiseQuotient(scales.forces);
    }
    signals_.push_back(std::move(signals));
    forces_.push_back(std::move(forces));
  }
}

void ScaledWindows::Gather(std::span<const Window> windows, std::vector<MatrixXf>* batch,
                           MatrixXf* forces) const {
  const auto steps = static_cast<Index>(batch->size());
  const auto rows = static_cast<Index>(windows.size());
  for (MatrixXf& step : *batch) step.resize(rows, signals_.front().rows());
  forces->resize(rows, 3);
  for (Index row = 0; row < rows; ++row) {
    const Window& w = windows[static_cast<std::size_t>(row)];
    const auto last = static_cast<Index>(w.last);
    for (Index t = 0; t < steps; ++t) {
      (*batch)[static_cast<std::size_t>(t)].row(row) =
          signals_[w.recording].col(last - steps + 1 + t).transpose();
    }
    forces->row(row) = forces_[w.recording].col(last).transpose();
  }
}

}  // namespace palpate
