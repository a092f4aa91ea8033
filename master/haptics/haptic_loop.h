// The loop that holds a hand: each millisecond a force, whatever slave and link do, and zero at the
// end. Talks to the rest of the program through latest-value slots and a ring, all wait-free.
#pragma once

#include <atomic>
#include <optional>
#include <stop_token>

#include "master/device/device.h"
#include "master/haptics/force_chain.h"
#include "master/haptics/operator_machine.h"
#include "master/haptics/operator_requests.h"
#include "master/haptics/periodic.h"
#include "master/haptics/record/tick_record.h"
#include "master/haptics/renderer.h"
#include "master/haptics/spsc_ring.h"
#include "master/haptics/tare.h"
#include "master/link/patch_watch.h"
#include "master/link/slave_link.h"

namespace palpate {

class HapticLoop {
 public:
  struct Options {
    RenderMode render = RenderMode::kLocal;
    TeleopTransform transform;  // scales and rotation; the offset comes with the states
    // The master's own, which nobody else can raise.
    double force_limit = 3.3;  // at the hand [N], > 0; the scene's and the device's also hold
    double slew_limit = 0.2;   // of the force, both ways [N/ms], > 0
    double max_age = 0.2;      // of what is rendered, beside its way through the network [s]
    double dead_after = kUsualDeadAfter;  // without a state the link is dead [s], within bounds
    std::uint32_t settings_revision = 0;  // of what `transform` was read from
  };
  struct Slots {
    LatestValue<ReceivedState>* states = nullptr;      // read here
    LatestValue<OperatorCommand>* commands = nullptr;  // written here
    SpscRing<TickRecord>* records = nullptr;           // written here
    LatestValue<RemoteSettings>* settings = nullptr;   // read here; null: they never change
    LatestValue<ReceivedPatch>* patches = nullptr;     // read here; null: none comes
    const OperatorRequests* requests = nullptr;        // read here; null: nobody asks
  };
  struct Stats {
    PeriodicStats periodic;
    LatencyHistogram compute_us;  // of Read, Tick, WriteForce and Guide together [us]
  };

  // All of `slots` outlive the loop. Throws std::invalid_argument: force limit or scales not > 0.
  HapticLoop(const Options& options, const Slots& slots);

  // Runs for `length`, until `stop` or until the device's motion is over. The force then fades, the
  // last one is zero.
  void Run(Device& device, Clock::duration length, const std::stop_token& stop) noexcept;

  // One tick: the force for the hand [N] when the device says `reading` at `now`. Allocates
  // nothing, locks nothing, always finite and within the limit.
  Eigen::Vector3d Tick(const DeviceReading& reading, Time now) noexcept;
  // Where the surface is, as of the last tick; unknown unless following.
  [[nodiscard]] DeviceGuide guide() const noexcept;
  // The operator's emergency stop: told with each command until the slave says that it stands and
  // has heard of this one; the hand is let go. Any thread, also a signal handler's.
  void EmergencyStop() noexcept { ++stops_asked_; }
  // So many there were, and of so many nobody has said yet that they acted. Any thread.
  [[nodiscard]] std::uint32_t stops_asked() const noexcept { return stops_asked_; }
  [[nodiscard]] bool stop_is_wanted() const noexcept { return stops_asked_ != stops_acted_; }
  // The slave stood, by another way, after the first `stops` were asked for. Any thread.
  void StopActed(std::uint32_t stops) noexcept;
  // Lets go: the command that leaves the tool standing. After the last tick.
  void Release(Time now) noexcept;

  // Of the last tick; after Run from any thread.
  [[nodiscard]] const TickRecord& record() const noexcept { return record_; }
  [[nodiscard]] const PassivityControl& passivity() const noexcept { return passivity_; }
  [[nodiscard]] const Stats& stats() const noexcept { return stats_; }

 private:
  [[nodiscard]] double ToSeconds(Time t) const noexcept { return SecondsBetween(origin_, t); }
  [[nodiscard]] DeviceGuide Surface() const noexcept;
  void TakeState(Time now) noexcept;
  void TakeRequests() noexcept;
  void TakeSettings() noexcept;
  void TakePatch(double now) noexcept;
  void CompareWithSlave(const SlaveState& state) noexcept;
  // Whether what the slave says may be rendered; why not is in the reasons.
  [[nodiscard]] bool Trusts(Time now) noexcept;
  [[nodiscard]] bool KeepsOffset() noexcept;
  [[nodiscard]] DeviceReading Checked(const DeviceReading& reading) noexcept;
  void StepMachine(Time now, bool engaged) noexcept;
  void OnStateChange(OperatorState to) noexcept;
  void FadeOutOfHold(double now) noexcept;
  void RunChain(const DeviceReading& reading, double now, double dt) noexcept;
  // Whether the newest state is of a slave that stands and knows the last stop asked for.
  [[nodiscard]] bool KnowsStop() const noexcept;
  // That leaves the tool standing where it was last sent.
  [[nodiscard]] OperatorCommand NextCommand(Time now) noexcept;
  void PutCommand(const DeviceReading& reading, Time now) noexcept;

  Options options_;
  Slots slots_;
  Renderer renderer_;
  OperatorMachine machine_;
  PassivityControl passivity_;
  OutputBlend output_;
  Tare tare_;
  std::uint32_t tares_asked_ = 0;
  TeleopTransform transform_;  // with the offset of the current epoch
  std::optional<ReceivedState> newest_;
  const ReceivedPatch* patch_ = nullptr;  // that came last, in its slot; null: it was taken over
  Time judged_at_{};                      // sensed then, slave's clock
  RemoteSettings settings_;               // as read last
  bool settings_wait_ = false;            // until nobody follows, to come in force
  std::uint32_t offset_epoch_ = 0;        // that the transform's offset belongs to
  DeviceReading last_reading_;            // the last good one
  Eigen::Vector3d commanded_p_M_{0, 0, 0};
  Eigen::Vector3d sent_{0, 0, 0};
  std::uint64_t command_sequence_ = 0;
  std::atomic<std::uint32_t> stops_asked_{0}, stops_acted_{0};
  // Stops put into commands, and when the last of them was first.
  std::uint32_t stops_put_ = 0;
  std::uint64_t stop_sequence_ = 0;
  Time stop_put_at_{};
  bool hold_is_fading_ = false;
  bool started_ = false;
  Time origin_{}, last_tick_{};
  TickRecord record_;
  Stats stats_;
};

}  // namespace palpate
