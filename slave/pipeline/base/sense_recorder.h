// Records all inputs of and queries to a sensing.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include "slave/capture/sample_tap.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

// Outlives the sense.
class SenseRecorder : public SampleTap {
 public:
  // A sensing is about to be created. `p_S_tip`: tool position of its simulated environment, S [m];
  // nullopt: a real one.
  virtual void Begin(const std::optional<Eigen::Vector3d>& p_S_tip) = 0;
  // `sense`, with each call recorded.
  virtual std::unique_ptr<SensingPipeline> Watch(std::unique_ptr<SensingPipeline> sense) = 0;
};

}  // namespace palpate
