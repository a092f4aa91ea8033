// The devices of a simulated scene, connected to a slave in the same process. They replace
// palpate-simulator.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "slave/live/slave.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

class SimulatedDevices {
 public:
  // `slave` outlives them, and has the same scene. Returns once it has used the first images and is
  // driven. Throws std::runtime_error: it does neither within a minute.
  SimulatedDevices(Scene scene, Slave* slave);

  // Displaces the camera: from now on its images are shifted downwards by this [px].
  void BumpCamera(int displacement) { displacement_ = displacement; }
  // Covers the camera's images with white, or uncovers them.
  void CoverCamera(bool is_covered) { is_covered_ = is_covered; }

 private:
  void FeedImages(const std::stop_token& stop);
  void Drive(const std::stop_token& stop);

  const Scene scene_;
  Slave& slave_;
  const std::unique_ptr<SimulatedEnvironment> environment_;
  std::atomic<int> displacement_{0};
  std::atomic<bool> is_covered_{false};
  std::jthread drive_, feed_;
};

}  // namespace palpate
