// The simulated site's two cameras as a source of pairs like any other.
#pragma once

#include <cstdint>

#include "slave/capture/frame_source.h"
#include "slave/site/points/stereo_site.h"

namespace palpate {

// Takes a pair every 1 / rate seconds of real time; late ones are skipped, not caught up with.
class SimulatedPair final : public StereoSource {
 public:
  // `site` must outlive this; `rate` [Hz], > 0, that of the scene.
  SimulatedPair(StereoSite& site, double rate);
  std::optional<StereoPair> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  StereoSite& site_;
  double rate_;  // [Hz]
  std::uint64_t sequence_ = 0;
  Time due_{};
};

}  // namespace palpate
