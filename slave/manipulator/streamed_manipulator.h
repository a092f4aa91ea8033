// A manipulator whose driver is a client (DriveTool). Its targets respect the scene's speeds and
// workspace; its reported positions are checked for plausibility.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "shared/link/priority_inheritance_mutex.h"
#include "slave/capture/sender_clock.h"
#include "slave/manipulator/arm_fit.h"
#include "slave/manipulator/driven_arm.h"
#include "slave/manipulator/manipulator.h"
#include "slave/manipulator/tip_follower.h"
#include "slave/manipulator/tool_rotation.h"

namespace palpate {

// The manipulator has a fault and holds its last measured position while no driver is connected,
// the driver is silent for longer than the scene allows, reports a fault, or reports a tip outside
// the workspace or one that is unreachable since the last report.
class StreamedManipulator final : public Manipulator {
 public:
  using Now = Time (*)();
  // `now`: clock, replaced in tests. Throws the exceptions of TipFollower.
  explicit StreamedManipulator(const ManipulatorOptions& options, Now now = &Clock::now);

  bool Command(const Eigen::Vector3d& p_S_target) noexcept override;
  void Hold() noexcept override;
  void Stop() noexcept override;
  void Turn(const Eigen::Quaterniond& R_S_target) noexcept override;
  [[nodiscard]] Eigen::Vector3d Tip() const noexcept override;
  [[nodiscard]] std::optional<Eigen::Quaterniond> Rotation() const noexcept override;
  [[nodiscard]] Eigen::Vector3d TipAt(Time t) const noexcept override;
  [[nodiscard]] std::uint32_t frame() const noexcept override;
  [[nodiscard]] bool at_limit() const noexcept override;
  [[nodiscard]] bool carries_tool() const noexcept override { return true; }
  [[nodiscard]] bool is_faulty() const noexcept override { return IsFaultyAt(now_()); }
  [[nodiscard]] std::optional<ArmHealth> health() const override;
  [[nodiscard]] std::optional<Eigen::Vector3d> measured_force() const noexcept override;
  [[nodiscard]] StreamedManipulator* driven() noexcept override { return this; }

  // The functions below serve the driver's stream. They are thread-safe and short.
  //
  // The first reading of `driver` makes it the driver. nullopt: accepted. Otherwise the reading is
  // not used.
  std::optional<DriverRefusal> Take(DriverId driver, const std::string& name,
                                    const ArmReading& reading, Time arrived_at);
  // Ends the driver's control, if it has it.
  void Leave(DriverId driver);
  // The target at `now`; the arm's time advances from call to call.
  ArmAim Aim(Time now);

 private:
  static constexpr std::size_t kMaxKept = 512;  // reports: half a second at 1 kHz

  struct Driver {
    DriverId id = 0;  // 0: no driver
    std::string name;
    std::uint32_t frame = 0;  // count of drivers so far; each has its own origin
    SenderClock clock;
    std::uint64_t sequence = 0;  // of the newest reading, accepted or not
    Time measured_at{};          // time of that reading by the driver's clock
    Time received_at{};          // its arrival by the slave's clock
    std::uint64_t reports = 0;
  };
  struct Kept {
    Time at{};  // slave's clock
    Eigen::Vector3d p_S_tip{0, 0, 0};
  };

  [[nodiscard]] bool IsFaultyAt(Time now) const noexcept;
  // Requires mutex_ to be held, as all functions below.
  [[nodiscard]] std::optional<DriverRefusal> Rejects(DriverId driver, const ArmReading& reading,
                                                     Time arrived_at) const;
  // Returns the fault of a readable reading; empty: none.
  [[nodiscard]] std::string FindFault(const ArmReading& reading, Time measured_at) const;
  void BeginWith(DriverId driver, const std::string& name);
  void Keep(const ArmReading& reading, Time measured_at) noexcept;
  void HoldPosition() noexcept;
  void Fail(const std::string& why, Time now);
  [[nodiscard]] std::string SilenceInWords(Time now) const;
  [[nodiscard]] bool IsSilent(Time now) const noexcept;
  [[nodiscard]] bool HasFault(Time now) const noexcept { return !fault_.empty() || IsSilent(now); }

  const ManipulatorOptions options_;
  const Now now_;
  mutable PriorityInheritanceMutex mutex_;  // guards everything below
  TipFollower follower_;
  ToolRotation rotation_;
  ArmAim::Motion motion_ = ArmAim::Motion::kHold;
  std::uint64_t aims_ = 0;
  std::optional<Time> stepped_at_;

  Driver driver_;
  std::string fault_;  // the last fault, until it has been absent for a while
  Time wrong_at_{};
  std::optional<ArmReading> reading_;  // the newest that was accepted
  std::array<Kept, kMaxKept> kept_;    // the last ones, times rise
  std::size_t count_ = 0;              // largest age of the stored readings of this driver
  ArmFit fit_;
  double period_ = 0;  // between reports, smoothed [s]
};

}  // namespace palpate
