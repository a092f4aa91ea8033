// Windows of samples, scaled and laid out as training reads them.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/tactile/recordings/labelled_recording.h"

namespace palpate {

// Signals and forces are divided by these; rest, which is 0, stays 0.
struct TrainingScales {
  Eigen::VectorXf signals;  // E1 to E19[, pac0, pdc] [counts]
  Eigen::Vector3f forces;   // [N]
};

// Their rms over the windows' last samples. A signal that hardly moves compared with its kind
// (electrodes; pac; pdc) is noise and must not be blown up: at least a quarter of the kind's rms;
// in the same way for axes of force, a tenth of the largest.
// Throws std::invalid_argument: all electrodes, or all forces, are constant or not finite.
TrainingScales ScalesOf(std::span<const LabelledRecording> recordings,
                        std::span<const Window> windows, int inputs);

class ScaledWindows {
 public:
  ScaledWindows(std::span<const LabelledRecording> recordings, const TrainingScales& scales);

  // Fills `batch` (one matrix windows x inputs per step, the last one the present) and `forces`
  // (windows x 3).
  void Gather(std::span<const Window> windows, std::vector<Eigen::MatrixXf>* batch,
              Eigen::MatrixXf* forces) const;

 private:
  std::vector<Eigen::MatrixXf> signals_;  // per recording, inputs x samples
  std::vector<Eigen::MatrixXf> forces_;   // per recording, 3 x samples
};

}  // namespace palpate
