#include "slave/site/points/simulated_pair.h"

#include <algorithm>
#include <thread>
#include <utility>

#include <spdlog/fmt/fmt.h>

namespace palpate {

SimulatedPair::SimulatedPair(StereoSite& site, double rate) : site_(site), rate_(rate) {}

std::optional<StereoPair> SimulatedPair::Next(const std::stop_token& stop) {
  const Clock::duration period = Seconds(1 / rate_);
  const Time now = Clock::now();
  // A late pair keeps its raster as long as less than a period was lost.
  due_ = due_ + 2 * period > now ? due_ + period : now;
  // A slow camera must not delay the end: sleep in short stretches.
  while (!stop.stop_requested() && Clock::now() < due_) {
    const Time wake = std::min(due_, Clock::now() + std::chrono::milliseconds(50));
    std::this_thread::sleep_until(Clock::ToSteady(wake));
  }
  if (stop.stop_requested()) return std::nullopt;
  StereoPair pair;
  pair.sensed_at = Clock::now();
  StereoPictures pictures = site_.TakePictures();
  pair.left = std::move(pictures.left);
  pair.right = std::move(pictures.right);
  pair.sequence = ++sequence_;
  return pair;
}

std::string SimulatedPair::description() const {
  return fmt::format("simulated pair of cameras at {:g} Hz", rate_);
}

}  // namespace palpate
