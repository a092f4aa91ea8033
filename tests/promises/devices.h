// The devices of a scene and their disturbances, in the same process as a slave on a driven clock.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "palpate/v1/simulation.pb.h"

#include "slave/live/live_slave.h"
#include "slave/live/simulated_drivers.h"
#include "slave/scene/scene.h"
#include "slave/simulator/environment/simulated_environment.h"
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
  // Largest true ones since the sample before [N], [m]. The depth is that below the surface at
  // rest.
  double force = 0, depth = 0;
  // Largest distance of the tool from where the operator leads it while FOLLOWING, since the sample
  // before [m].
  double off_target = 0;
  std::vector<std::string> alarms;
};

// A simulated scene whose tool is moved.
class Site {
 public:
  explicit Site(const Scene& scene);
  [[nodiscard]] v1::SimulatedTruth MoveTool(const Eigen::Vector3d& p_S_tip);
  // The sample of this moment; `t`: its time [s].
  [[nodiscard]] v1::SimulatedSample Take(double t);

 private:
  const Scene& scene_;
  const std::unique_ptr<SimulatedEnvironment> environment_;
  std::unique_ptr<FrameSource> frames_;
  std::unique_ptr<StereoSource> pairs_;
  std::unique_ptr<TactileSource> fingertips_;
};

class Devices {
 public:
  Devices(const Scene& scene, LiveSlave& slave) : scene_(scene), slave_(slave), drivers_(slave) {}

  // Throws std::runtime_error if the answer to a call differs from the answer in `event`.
  void Begin(const Disturbance& event);
  // Manipulator and operator until the sample, then the sample; it is its time afterwards.
  Seen Send(v1::SimulatedSample sample);
  // The same with the sample that `site` gives at `t` [s], after the tool went where the slave
  // aims.
  Seen Follow(double t, Site* site);

 private:
  void Alter(v1::Image* image, int side, const v1::SimulatedTruth& truth);
  void Alter(v1::TactileSample* sample, const v1::SimulatedTruth& truth);
  void Freeze(int side, v1::SimulatedSample* sample) const;
  // `truth_at`: the true state at a time [s].
  void Await(double t, const std::function<v1::SimulatedTruth(double)>& truth_at);
  Seen Sense(double t, v1::SimulatedSample sample);
  void Report(double t, v1::SimulatedTruth truth);
  void Operate();
  void SendCommand();
  bool Stroke();
  // Compares the tool with where the operator leads it.
  void CompareTarget();
  [[nodiscard]] Eigen::Vector3d EncoderOffset() const;

  const Scene& scene_;
  LiveSlave& slave_;
  SimulatedDrivers drivers_;
  std::vector<Disturbance> events_;
  std::mt19937 random_{7};
  std::deque<v1::SimulatedSample> before_;
  v1::TactileSample held_;
  v1::SimulatedTruth reported_;
  double t_ = 0;
  Eigen::Vector3d p_S_tip_{0, 0, 0};                // of the tool that follows
  std::optional<Eigen::Vector3d> p_S_scaled_from_;  // where the encoders' scale began
  double force_ = 0, depth_ = 0;                    // see Seen
  std::string operates_;
  double pause_ = 0;                   // between strokes [s]
  long tick_ = 0;                      // of the present stroke
  bool is_near_ = false;               // to a guard
  std::optional<LocalModel> surface_;  // at rest
  OperatorCommand command_;
  std::deque<OperatorCommand> sent_;
  long ticks_ = 0;
  // Device and tool at the beginning of the engagement, M and S.
  std::optional<std::array<Eigen::Vector3d, 2>> engaged_at_;
  std::uint32_t engaged_epoch_ = 0;
  double off_target_ = 0;  // see Seen
  std::uint64_t states_ = 0;
  std::vector<std::uint64_t> stops_;  // numbers of the active stops
};

}  // namespace palpate::promises
