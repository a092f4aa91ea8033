#include "slave/tactile/training/estimate_forces.h"

#include <limits>
#include <memory>
#include <optional>

namespace palpate {
namespace {

std::vector<Eigen::Vector3f> EstimateAll(const ForceNetwork& network,
                                         const LabelledRecording& recording) {
  const std::unique_ptr<ForceEstimate> estimate = network.Windowed();
  std::vector<double> outputs(static_cast<std::size_t>(network.info().outputs));
  std::vector<Eigen::Vector3f> forces;
  forces.reserve(recording.change.size());
  for (const TactileSignals& change : recording.change) {
    if (estimate->Push(change, outputs)) {
      forces.push_back(Eigen::Vector3d(outputs[0], outputs[1], outputs[2]).cast<float>());
    } else {
      forces.push_back(Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN()));
    }
  }
  return forces;
}

}  // namespace

std::vector<Eigen::Vector3f> EstimateForces(const ForceNetwork& network,
                                            std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows) {
  std::vector<std::optional<std::vector<Eigen::Vector3f>>> all(recordings.size());
  std::vector<Eigen::Vector3f> forces;
  forces.reserve(windows.size());
  for (const Window& w : windows) {
    if (!all[w.recording]) all[w.recording] = EstimateAll(network, recordings[w.recording]);
    forces.push_back((*all[w.recording])[w.last]);
  }
  return forces;
}

std::vector<Eigen::Vector3f> MeasuredForces(std::span<const LabelledRecording> recordings,
                                            std::span<const Window> windows) {
  std::vector<Eigen::Vector3f> forces;
  forces.reserve(windows.size());
  for (const Window& w : windows) forces.push_back(recordings[w.recording].force[w.last]);
  return forces;
}

}  // namespace palpate
