// Who keeps all that a sense is given and asked.
#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include "slave/capture/sample_tap.h"
#include "slave/pipeline/sensing_pipeline.h"

namespace palpate {

// Outlives the sense.
class SenseRecorder : public SampleTap {
 public:
  // A sense is about to be made. `p_S_tip`: where the tool of its simulated site is, S [m];
  // nullopt: it is a real one.
  virtual void Begin(const std::optional<Eigen::Vector3d>& p_S_tip) = 0;
  // `sense`, with each call kept.
  virtual std::unique_ptr<SensingPipeline> Watch(std::unique_ptr<SensingPipeline> sense) = 0;
};

}  // namespace palpate
