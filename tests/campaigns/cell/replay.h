// Plays samples to a slave in this process, and takes its estimates.
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/pipeline/offline/offline_report.h"
#include "slave/scene/scene.h"
#include "tests/campaigns/cell/run.h"

namespace palpate::campaign {

// A sample as the sense is given it: at the time of the sample `index` of the run.
struct Altered {
  std::size_t index = 0;
  cv::Mat left, right;
  TactileFrame touch;
};

// Calls `take` with every estimate after `rest` samples: index of the sample, reported and true
// force. `stated`: the scene that the slave is given. `arm_error`: of the encoders' tip along y
// [m]. Throws what the slave throws.
using Taker =
    std::function<void(std::size_t index, const StateRow& row, const Eigen::Vector3d& truth)>;
void Replay(const Run& run, const Scene& stated, const std::vector<Altered>& samples,
            std::size_t rest, double arm_error, const Taker& take);

}  // namespace palpate::campaign
