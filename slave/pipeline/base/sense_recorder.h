// Records all inputs of and queries to a sensing.
#pragma once

#include <memory>
#include <string>

#include "slave/capture/sample_tap.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {

// Outlives the sense.
class SenseRecorder : public SampleTap {
 public:
  // A sensing is about to be created.
  virtual void Begin() = 0;
  // `sense`, with each call recorded.
  virtual std::unique_ptr<SensingPipeline> Watch(std::unique_ptr<SensingPipeline> sense) = 0;
  // Why the recording has ended, or that it falls behind; empty: neither. Thread-safe.
  [[nodiscard]] virtual std::string trouble() const = 0;
};

}  // namespace palpate
