// A slave for tests: a soft wall behind a plane, a tool that follows without delay, and a link with
// delay, jitter and loss. Its time advances by steps of the test.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <random>

#include "master/haptics/received.h"
#include "shared/link/latest_value.h"

namespace palpate {

class VirtualSlave {
 public:
  struct Options {
    double K = 500;                   // of the wall, along its normal [N/m]
    double shear = 0;                 // tangential stiffness, from the entry point [N/m]
    Eigen::Vector3d normal{0, 1, 0};  // outward, S
    double surface = -0.004;          // the wall begins at normal . p = surface [m]
    Eigen::Vector3d home{0, 0, 0};    // initial position of the tool, S [m]
    double delay = 0;                 // each way [s]
    double jitter = 0;                // on top, uniform up to it [s]
    double loss = 0;                  // share of messages [-]
    double clock_offset = 1000;       // slave's clock minus master's [s]
    double sensor_rate = 60;          // [Hz]
    int window = 1;                   // samples that an estimate is the mean of: a network's lag
    bool several = false;             // two fingertips; the second has half of the first's force
    double state_rate = 500;          // [Hz]
    TeleopTransform transform;        // scales and rotation
  };
  explicit VirtualSlave(const Options& options)
      : options_(options), entry_(OnPlane(options.home)), tip_(options.home) {}

  // Simulates one millisecond: receives commands, moves, senses and sends.
  void Step(Time now, LatestValue<OperatorCommand>* commands, LatestValue<ReceivedState>* states);

  // The members below change what is sent.
  bool silent = false;  // nothing is sent
  std::function<void(SlaveState*)>
      falsify;                           // changes the sent state; empty: the true state is sent
  bool forgets = false;                  // epoch 0, as after a restart
  Validity validity = Validity::kValid;  // of the sent states
  Phase forced_phase = Phase::kReady;    // kEstop: sent instead of the real one
  double K() const { return options_.K; }
  void set_K(double K);  // the object changes, and so does the model's revision
  [[nodiscard]] Eigen::Vector3d TrueForce() const { return ForceAt(tip_); }
  [[nodiscard]] const Eigen::Vector3d& tip() const { return tip_; }
  [[nodiscard]] double depth() const { return DepthOf(tip_); }  // of the tip in the wall [m]
  [[nodiscard]] bool engaged() const { return engaged_; }

 private:
  // Messages in transit, by arrival time.
  template <class T>
  using Line = std::multimap<Time, T>;
  [[nodiscard]] double DepthOf(const Eigen::Vector3d& p) const {
    return options_.surface - options_.normal.dot(p);
  }
  [[nodiscard]] Eigen::Vector3d OnPlane(const Eigen::Vector3d& p) const {
    return p + DepthOf(p) * options_.normal;
  }
  [[nodiscard]] Eigen::Vector3d ForceAt(const Eigen::Vector3d& p) const;
  void MoveTo(const Eigen::Vector3d& p);
  [[nodiscard]] bool IsLost() { return uniform_(random_) < options_.loss; }
  [[nodiscard]] Time Arrival(Time now) {
    return now + Seconds(options_.delay + options_.jitter * uniform_(random_));
  }
  void Follow(const OperatorCommand& command);
  void TakeSample(Time now);
  [[nodiscard]] SlaveState Compose(Time now) const;

  Options options_;
  TeleopTransform mapping_;
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> uniform_{0, 1};
  Line<OperatorCommand> commands_;
  Line<SlaveState> states_;
  Eigen::Vector3d entry_;  // where the tip crossed the plane, or would cross it
  Eigen::Vector3d tip_, sensed_tip_{0, 0, 0}, sensed_force_{0, 0, 0};
  std::deque<Eigen::Vector3d> window_forces_;  // the window's forces
  Time sensed_at_{}, sent_at_{};
  Time echo_{}, taken_at_{};  // of the newest command: master's clock, slave's
  std::uint64_t command_sequence_ = 0, state_sequence_ = 0, delivered_ = 0;
  std::uint32_t epoch_ = 0, revision_ = 1;
  bool engaged_ = false;
};

}  // namespace palpate
