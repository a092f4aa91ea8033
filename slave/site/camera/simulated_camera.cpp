#include "slave/site/camera/simulated_camera.h"

#include <algorithm>
#include <thread>

#include <spdlog/fmt/fmt.h>

namespace palpate {

SimulatedCamera::SimulatedCamera(SimulatedSite& site, double rate) : site_(site), rate_(rate) {}

std::optional<Frame> SimulatedCamera::Next(const std::stop_token& stop) {
  const Clock::duration period = Seconds(1 / rate_);
  const Time now = Clock::now();
  due_ = due_ + period > now ? due_ + period : now;
  // A slow camera must not delay the end: sleep in short stretches.
  while (!stop.stop_requested() && Clock::now() < due_) {
    const Time wake = std::min(due_, Clock::now() + std::chrono::milliseconds(50));
    std::this_thread::sleep_until(Clock::ToSteady(wake));
  }
  if (stop.stop_requested()) return std::nullopt;
  Frame frame;
  frame.sensed_at = Clock::now();
  frame.image = site_.TakePicture();
  frame.sequence = ++sequence_;
  return frame;
}

std::string SimulatedCamera::description() const {
  return fmt::format("simulated site, camera at {:g} Hz", rate_);
}

}  // namespace palpate
