// Sources of a simulated environment in the same process.
#pragma once

#include <memory>

#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

class EnvironmentPlayer final : public SamplePlayer {
 public:
  // `environment` and `scene` outlive the player; see SimulatedEnvironment.
  EnvironmentPlayer(SimulatedEnvironment& environment, const Scene& scene)
      : environment_(environment), scene_(scene) {}

  std::unique_ptr<FrameSource> OpenFrames() override {
    return environment_.OpenCamera(scene_, ScriptedRun{});
  }
  std::unique_ptr<StereoSource> OpenPairs() override {
    return environment_.OpenPair(scene_, ScriptedRun{});
  }
  std::unique_ptr<TactileSource> OpenFingertips() override {
    return environment_.OpenFingertips(scene_, ScriptedRun{});
  }

 private:
  SimulatedEnvironment& environment_;
  const Scene& scene_;
};

}  // namespace palpate
