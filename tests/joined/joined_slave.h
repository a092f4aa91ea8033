// A slave with the product's operator port, estimate and emergency stop. Its object is a soft wall
// below y = 0, and its tool reaches its target immediately. The test sets the time.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "slave/live/latest_estimate.h"
#include "slave/live/operator_port.h"
#include "slave/live/stop_control.h"
#include "slave/live/stop_record.h"
#include "tests/slave/service/fake_slave.h"

namespace palpate {

// Thread-safe.
class InstantTool final : public Manipulator {
 public:
  bool Command(const Eigen::Vector3d& p_S_target) noexcept override;
  void Hold() noexcept override {}
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override;
  [[nodiscard]] bool at_limit() const noexcept override { return false; }
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }

 private:
  mutable std::mutex mutex_;
  Eigen::Vector3d p_S_tip_{0, 1e-3, 0};
};

// A stop record whose removal calls `during_end`, to simulate a slow removal.
class SlowStopRecord final : public StopRecord {
 public:
  void End() override;
  std::function<void()> during_end;  // empty: nothing happens
};

class JoinedSlave final : public FakeSlave {
 public:
  static constexpr double kStiffness = 500;  // of the wall [N/m]
  struct Scales {
    double position = 1, force = 1;
    bool operator==(const Scales&) const = default;
  };

  // `clock`: the slave's.
  explicit JoinedSlave(std::function<Time()> clock);

  // --- for tests. Estimates the contact at the current tip. `force`: estimated force [N]; nullopt:
  // the true one.
  void Sense(std::optional<double> force = {});
  // Does what the watchdog thread of a slave does.
  void Watch();
  // Returns whether an emergency stop arrived after which no reset has succeeded.
  [[nodiscard]] bool has_open_stop() const;
  [[nodiscard]] bool is_stop_recorded() const { return record_.is_active(); }
  [[nodiscard]] OperatorView view() const { return port_.view(); }
  [[nodiscard]] std::uint64_t stops() const { return port_.stops(); }
  [[nodiscard]] CommandCounts counts() const { return port_.counts(); }
  // Returns the settings of a revision.
  [[nodiscard]] Scales ScalesOf(std::uint32_t revision) const;
  [[nodiscard]] std::uint32_t revision() const;
  [[nodiscard]] TeleopTransform transform() const { return port_.transform(); }
  // Makes another stop arrive during the next reset, while the record is removed.
  void StopDuringNextReset();

  // --- Slave.
  void BeginOperating() override { port_.BeginOperating(); }
  bool Command(const OperatorCommand& command) noexcept override;
  void EndOperating() override { port_.EndOperating(); }
  SlaveState Compose(Time now) override;
  Events TakeEvents() override { return port_.TakeEvents(); }
  bool WaitForNewer(Time sensed_at, std::chrono::milliseconds timeout) override {
    return newest_.WaitForNewer(sensed_at, timeout);
  }
  [[nodiscard]] SlaveDescription Describe() const override;
  [[nodiscard]] SlaveStatus Status() const override;
  void SetParameters(const ParameterChange& change, Progress* progress) override;
  void Reset(std::uint64_t stops) override;
  void StopTool() noexcept override;
  void RecordStop(const std::string& reason) override { stop_control_.Record(reason); }

 private:
  [[nodiscard]] ContactState ContactNow() const;

  const std::function<Time()> clock_;
  InstantTool tool_;
  OperatorPort port_;
  LatestEstimate newest_;
  SlowStopRecord record_;
  StopControl stop_control_{port_, record_};
  mutable std::mutex mutex_;  // guards the members below
  std::map<std::uint32_t, Scales> scales_{{1, {}}};
  std::uint64_t sample_ = 0, stops_ = 0, ended_stops_ = 0;
  std::jthread other_client_;  // of StopDuringNextReset
};

}  // namespace palpate
