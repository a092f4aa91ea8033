// A simulated site that presses by itself, picture after picture on a clock of its own: what
// `process` runs over when nothing was recorded.
#pragma once

#include "slave/capture/frame_source.h"
#include "slave/site/camera/scripted_press.h"
#include "slave/site/camera/simulated_site.h"

namespace palpate {

class ScriptedCamera : public FrameSource {
 public:
  // Throws what SimulatedSite throws.
  explicit ScriptedCamera(const Scene& scene);
  std::optional<Frame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;
  // The truth when the last picture was taken.
  [[nodiscard]] const SiteTruth& truth() const { return truth_; }

 private:
  SimulatedSite site_;
  ScriptedPress press_;
  double rate_;  // [Hz]
  std::uint64_t sequence_ = 0;
  SiteTruth truth_;
};

}  // namespace palpate
