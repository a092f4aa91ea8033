// The devices of a scene and their disturbances, in the same process as a slave on a driven clock.
#pragma once

#include <cstdint>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "palpate/v1/simulation.pb.h"

#include "slave/live/live_slave.h"
#include "slave/live/simulated_drivers.h"
#include "slave/scene/scene.h"
#include "tests/promises/row.h"

namespace palpate::promises {

using Samples = std::vector<v1::SimulatedSample>;

inline Eigen::Vector3d VectorOf(const v1::Vec3& v) {
  return {v.x(), v.y(), v.z()};
}

// Returns the undisturbed samples of the devices of `scene`: those of palpate-simulator, of a depth
// camera that sees a plane, or of channels that rise by 1 per newton under presses of 4 N.
const Samples& SamplesOf(const Scene& scene);

// What operator and observers receive after a sample.
struct Seen {
  double t = 0;  // of the sample [s]
  SlaveState state;
  Events events;  // since the sample before
  v1::SimulatedTruth truth;
  std::vector<std::string> alarms;
};

class Devices {
 public:
  Devices(const Scene& scene, LiveSlave& slave) : scene_(scene), slave_(slave), drivers_(slave) {}

  // Throws std::runtime_error if the answer to a call differs from the answer in `event`.
  void Begin(const Disturbance& event);
  // Manipulator and operator until the sample, then the sample; it is its time afterwards.
  Seen Send(v1::SimulatedSample sample);

 private:
  void Alter(v1::Image* image, int side, const v1::SimulatedTruth& truth);
  void Alter(v1::TactileSample* sample, const v1::SimulatedTruth& truth);
  void Freeze(int side, v1::SimulatedSample* sample) const;
  void Await(const v1::SimulatedSample& sample, double t);
  void Operate();

  const Scene& scene_;
  LiveSlave& slave_;
  SimulatedDrivers drivers_;
  std::vector<Disturbance> events_;
  std::mt19937 random_{7};
  std::deque<v1::SimulatedSample> before_;
  v1::TactileSample held_;
  v1::SimulatedTruth reported_;
  double t_ = 0;
  std::string operates_;
  OperatorCommand command_;
  std::uint64_t states_ = 0;
  std::vector<std::uint64_t> stops_;  // numbers of the active stops
};

}  // namespace palpate::promises
