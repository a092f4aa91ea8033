// The devices of a simulated scene, connected to a slave in the same process: what
// palpate-simulator is to a slave elsewhere.
#pragma once

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

 private:
  void FeedImages(const std::stop_token& stop);
  void Drive(const std::stop_token& stop);

  const Scene scene_;
  Slave& slave_;
  const std::unique_ptr<SimulatedEnvironment> environment_;
  std::jthread drive_, feed_;
};

}  // namespace palpate
