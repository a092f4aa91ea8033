// Checks while running whether the assumptions of `model.kind: auto` for its choice still hold.
#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/state/slave_state.h"
#include "slave/scene/scene.h"

namespace palpate {

// Compares the depth that was studied and the time limit of an update with the estimates. A
// violation is reported once, after the contact ends: nothing can change before, and then the
// largest depth is known.
class ModelValidityMonitor {
 public:
  struct Breach {
    double depth = 0;   // depth for the new decision [m]
    std::string words;  // the violation, one sentence
  };
  // Called by a thread of the monitor with the lowest priority; must not throw.
  using Remedy = std::function<void(const Breach&, const std::stop_token&)>;

  ModelValidityMonitor(const Scene& scene, Remedy remedy);

  // For each sample. `update`: time from observation to force [s]. One thread.
  void Update(const ContactEstimate& estimate, bool touches, double update);

 private:
  void Run(const std::stop_token& stop);
  [[nodiscard]] bool IsBroken() const noexcept;

  const double budget_;             // of an update [s]
  double late_from_;                // a longer update counts [s]
  double studied_;                  // to that depth [m]
  double deepest_ = 0;              // of this contact [m]
  int updates_ = 0, slow_ = 0;      // with the object touched, of this window
  int late_ = 0;                    // the slow ones of the last whole window
  PriorityInheritanceMutex mutex_;  // guards the next one
  std::optional<Breach> breach_;    // the violation that is not yet handled
  PriorityInheritanceCondition changed_;
  const Remedy remedy_;
  std::jthread thread_;
};

}  // namespace palpate
