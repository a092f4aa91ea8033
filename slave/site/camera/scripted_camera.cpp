#include "slave/site/camera/scripted_camera.h"

#include <spdlog/fmt/fmt.h>

namespace palpate {
namespace {

constexpr int kStepsPerPicture =
    16;  // so that the tool's path between two pictures is followed, not jumped

}  // namespace

ScriptedCamera::ScriptedCamera(SimulatedSite& site, const Scene& scene)
    : site_(site), press_(scene), rate_(scene.sense.Find<Camera>()->rate) {
  site_.MoveTool(press_.Tip(0));
}

std::optional<Frame> ScriptedCamera::Next(const std::stop_token& stop) {
  const double t = static_cast<double>(sequence_) / rate_;
  if (stop.stop_requested() || t > press_.duration()) return std::nullopt;
  for (int step = kStepsPerPicture - 1; step >= 0 && sequence_ > 0; --step) {
    site_.MoveTool(press_.Tip(t - step / (kStepsPerPicture * rate_)));
  }
  Frame frame;
  frame.sensed_at = Time{} + Seconds(t);
  frame.sequence = ++sequence_;
  frame.image = site_.TakePicture();
  return frame;
}

std::string ScriptedCamera::description() const {
  return fmt::format("simulated site, scripted press, camera at {:g} Hz", rate_);
}

}  // namespace palpate
