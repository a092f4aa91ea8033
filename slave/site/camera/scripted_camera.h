// A simulated site that presses by itself, picture after picture on a clock of its own: what
// `process` runs over when nothing was recorded.
#pragma once

#include "slave/capture/frame_source.h"
#include "slave/site/camera/scripted_press.h"
#include "slave/site/camera/simulated_site.h"

namespace palpate {

class ScriptedCamera : public FrameSource {
 public:
  // `site` of that scene must outlive this. Throws what ScriptedPress throws.
  ScriptedCamera(SimulatedSite& site, const Scene& scene);
  std::optional<Frame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  SimulatedSite& site_;
  ScriptedPress press_;
  double rate_;  // [Hz]
  std::uint64_t sequence_ = 0;
};

}  // namespace palpate
