#include "slave/site/fingertips/simulated_fingers.h"

#include <algorithm>
#include <thread>

#include <spdlog/fmt/fmt.h>

namespace palpate {

SimulatedFingers::SimulatedFingers(TactileSite& site, double rate) : site_(site), rate_(rate) {}

std::optional<TactileFrame> SimulatedFingers::Next(const std::stop_token& stop) {
  const Clock::duration period = Seconds(1 / rate_);
  const Time now = Clock::now();
  // A late sample keeps its raster as long as less than a period was lost.
  due_ = due_ + 2 * period > now ? due_ + period : now;
  // A slow source must not delay the end: sleep in short stretches.
  while (!stop.stop_requested() && Clock::now() < due_) {
    const Time wake = std::min(due_, Clock::now() + std::chrono::milliseconds(50));
    std::this_thread::sleep_until(Clock::ToSteady(wake));
  }
  if (stop.stop_requested()) return std::nullopt;
  return site_.TakeSample(Clock::now());
}

std::string SimulatedFingers::description() const {
  return fmt::format("simulated fingertips at {:g} Hz", rate_);
}

}  // namespace palpate
