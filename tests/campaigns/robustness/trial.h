// Runs one case on one stage: the sense of the scene processes the altered samples, and each
// estimate is compared with the true value.
#pragma once

#include <cstddef>
#include <functional>
#include <string>

#include <Eigen/Core>

#include "slave/pipeline/offline/offline_report.h"
#include "tests/campaigns/robustness/case.h"
#include "tests/campaigns/robustness/stage.h"

namespace palpate::robustness {

// A `valid` estimate whose error exceeds both limits is an undetected error.
inline constexpr double kSilentSigmas = 3;    // of the reported sigma
inline constexpr double kSilentShare = 0.05;  // of the largest true force
// Further requirements of kRight.
inline constexpr double kRightRms = 0.05;   // of the largest true force, where `valid`
inline constexpr double kRightValid = 0.8;  // of all samples

// Counts over the samples after rest; for pinches, over each finger.
struct Score {
  // Of all samples: flagged or not, in contact or not; `touching`: valid ones in contact.
  std::size_t samples = 0, valid = 0, touching = 0, silent = 0;
  // Error of forces that are `valid` and in contact, relative to the largest true force [-].
  double rms = 0;
  double worst = 0;  // largest error of the same forces, relative to the largest true force [-]
  double sigma = 0;  // median sigma of the same forces, relative to the largest true force [-]
  double z = 0;      // rms of error / sigma of the same forces [-]
  // The most frequent reason where it is not `valid`; `refused: ...` at the start.
  std::string why;

  [[nodiscard]] bool Holds(Demand demand) const;
};

// Calls `take` with every estimate after rest: sample number, reported values, true values.
using Taker =
    std::function<void(std::size_t index, const StateRow& row, const Eigen::Vector3d& truth)>;
void Replay(Stage& stage, const Alteration& alteration, const Taker& take);

Score Try(Stage& stage, const Case& tried);

}  // namespace palpate::robustness
