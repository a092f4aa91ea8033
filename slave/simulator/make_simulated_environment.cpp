#include "slave/simulator/camera/simulated_site.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "slave/simulator/fingertips/tactile_site.h"
#include "slave/simulator/points/stereo_site.h"

namespace palpate {

std::unique_ptr<SimulatedEnvironment> MakeSimulatedEnvironment(const Scene& scene) {
  const auto* camera = scene.sense.Find<Camera>();
  const auto* stereo = scene.sense.Find<StereoCameras>();
  const auto* tactile = scene.sense.Find<Tactile>();
  if (camera && camera->source == Camera::Source::kSimulated) {
    return std::make_unique<SimulatedSite>(scene);
  }
  if (stereo && stereo->source == StereoCameras::Source::kSimulated) {
    return std::make_unique<StereoSite>(scene);
  }
  if (tactile && tactile->source == Tactile::Source::kSimulated) {
    return std::make_unique<TactileSite>(scene);
  }
  return nullptr;
}

}  // namespace palpate
