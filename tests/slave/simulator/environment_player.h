// Sources of a simulated environment in the same process.
#pragma once

#include <memory>

#include "slave/capture/pace.h"
#include "slave/simulator/environment/simulated_environment.h"

namespace palpate {

class EnvironmentPlayer final : public SamplePlayer {
 public:
  // `environment` and `scene` outlive the player; see SimulatedEnvironment.
  EnvironmentPlayer(SimulatedEnvironment& environment, const Scene& scene, const Pace& pace)
      : environment_(environment), scene_(scene), pace_(pace) {}

  std::unique_ptr<FrameSource> OpenFrames() override {
    return environment_.OpenCamera(scene_, pace_);
  }
  std::unique_ptr<StereoSource> OpenPairs() override {
    return environment_.OpenPair(scene_, pace_);
  }
  std::unique_ptr<TactileSource> OpenFingertips() override {
    return environment_.OpenFingertips(scene_, pace_);
  }

 private:
  SimulatedEnvironment& environment_;
  const Scene& scene_;
  const Pace pace_;
};

}  // namespace palpate
