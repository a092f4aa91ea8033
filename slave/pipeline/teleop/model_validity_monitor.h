// Whether what `model.kind: auto` took a model for still holds while it runs.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>

#include "shared/state/slave_state.h"
#include "slave/scene/scene.h"

namespace palpate {

// Held against what is felt: the depth that the model was studied to, and the time that an update
// may take. What is broken is told once, when the object has been let go: nothing can change before
// that, and by then the deepest place is known.
class ModelValidityMonitor {
 public:
  struct Breach {
    double depth = 0;   // to decide for anew [m]
    std::string words;  // what was broken, a sentence
  };
  // Called by a thread of the watch's own, after everything else in the machine; throws nothing.
  using Remedy = std::function<void(const Breach&, const std::stop_token&)>;

  ModelValidityMonitor(const Scene& scene, Remedy remedy);

  // Of each sample. `update`: from what was seen to the force [s]. One thread.
  void Update(const ContactEstimate& felt, bool touches, double update);

 private:
  void Run(const std::stop_token& stop);
  [[nodiscard]] bool IsBroken() const noexcept;

  const double budget_;           // of an update [s]
  double late_from_;              // an update that takes longer counts [s]
  double studied_;                // to that depth [m]
  double deepest_ = 0;            // of this press [m]
  int updates_ = 0, slow_ = 0;    // with the object touched, of this window
  int late_ = 0;                  // the slow ones of the last whole window
  std::mutex mutex_;              // guards the next one
  std::optional<Breach> breach_;  // that nobody has seen to
  std::condition_variable_any told_;
  const Remedy remedy_;
  std::jthread thread_;
};

}  // namespace palpate
