// The simulated site's fingertips as a source of samples like any other.
#pragma once

#include <cstdint>

#include "slave/capture/tactile_frame.h"
#include "slave/site/fingertips/tactile_site.h"

namespace palpate {

// Takes a sample every 1 / rate seconds of real time; late ones are skipped, not caught up with.
class SimulatedFingers final : public TactileSource {
 public:
  // `site` must outlive this; `rate` [Hz], > 0, that of the scene.
  SimulatedFingers(TactileSite& site, double rate);
  std::optional<TactileFrame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  TactileSite& site_;
  double rate_;
  Time due_{};
};

}  // namespace palpate
