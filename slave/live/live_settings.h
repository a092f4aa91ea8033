// Changes settings and models while a slave runs.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/live/latest_estimate.h"
#include "slave/live/operator_port.h"
#include "slave/live/slave.h"
#include "slave/pipeline/base/sensing_pipeline.h"
#include "slave/program/progress.h"
#include "slave/scene/scene.h"

namespace palpate {

// The scene with the parameters in force, and the description of the sensing. Settings change only
// while the operator is disengaged and there is no contact. Thread-safe.
class LiveSettings {
 public:
  // All must outlive this object. `sense_mutex` guards the sensing.
  LiveSettings(const Scene& scene, SensingPipeline* sense, PriorityInheritanceMutex* sense_mutex,
               OperatorPort* port, LatestEstimate* newest);

  // Rises with every change.
  [[nodiscard]] std::uint32_t revision() const { return revision_; }
  // Continues the numbering after `former`, so that the revision exceeds it.
  void ContinueRevisions(std::uint32_t former) { revision_ += former; }
  [[nodiscard]] Scene scene() const;
  // The largest force that the device can render, at the tool [N].
  [[nodiscard]] double FullScale() const;
  // Returns a copy. The second one is for the sensing thread, which alone completes the
  // description.
  [[nodiscard]] SenseInfo info() const;
  [[nodiscard]] const SenseInfo& sensing_info() const { return info_; }
  // The sensing has its first sample and its description is complete.
  void ReadInfo();

  // See Slave.
  void SetModel(const ModelChange& change, Progress* progress);
  void SetParameters(const ParameterChange& change, Progress* progress);
  // Throws std::logic_error if the operator is engaged or there is contact.
  void RefuseUnlessFree() const;

 private:
  [[nodiscard]] std::unique_ptr<PreparedModel> Prepare(const Scene& changed,
                                                       Progress* progress) const;
  void Adopt(const Scene& changed, std::unique_ptr<PreparedModel> prepared);

  SensingPipeline* sense_;
  PriorityInheritanceMutex* sense_mutex_;
  OperatorPort* port_;
  LatestEstimate* newest_;
  std::atomic<std::uint32_t> revision_{1};
  std::mutex change_mutex_;                 // one change at a time; locked while a model is built
  mutable PriorityInheritanceMutex mutex_;  // never locked long; guards the next two
  Scene scene_;
  SenseInfo info_;
};

}  // namespace palpate
