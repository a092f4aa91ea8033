// The simulated site's camera as a source of pictures like any other.
#pragma once

#include "slave/capture/frame_source.h"
#include "slave/site/camera/simulated_site.h"

namespace palpate {

// Takes a picture every 1 / rate seconds of real time; a late one is skipped, not caught up with.
class SimulatedCamera : public FrameSource {
 public:
  // `site` must outlive the camera; `rate` [Hz], > 0.
  SimulatedCamera(SimulatedSite& site, double rate);
  std::optional<Frame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  SimulatedSite& site_;
  double rate_;
  std::uint64_t sequence_ = 0;
  Time due_{};
};

}  // namespace palpate
