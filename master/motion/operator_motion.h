// The operator's own motion settings, between device and command: axes, clutch button, axis locks,
// workspace box, fixtures, and the speed limit near the contact.
//
//   reading -> axes -> M -> locks -> speed limit -> box -> command
//
// A command p = g(x) of the device's position x takes forces back by f_x = (dg/dx)^T f_p, so that
// device and command exchange the same power: what a lock or the box removes from the motion it
// also removes from the force. Springs at the device render locks, box and fixtures, and the lag:
// the distance by which a slow tool is behind the commanded position.
//
// Clutching does not move the tool: locks and lag begin at the engagement, and a box or fixture
// that the tool is outside of does not pull it in.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "master/device/device.h"
#include "master/motion/axis_map.h"
#include "master/motion/contact_speed.h"
#include "master/motion/fixture.h"
#include "shared/geometry/teleop_transform.h"

namespace palpate {

struct MotionOptions {
  static constexpr int kMaxButtons = 32;

  AxisMap axes;
  int clutch_button = 0;  // from 1; held, it opens the clutch; 0: none
  Eigen::Array<bool, 3, 1> locked{false, false, false};  // axes of M
  std::optional<Fixture> box;                            // also limits the command
  std::vector<Fixture> fixtures;
  double contact_speed = 0;  // of the tool [m/s]; 0: no limit
  double stiffness = 500;    // of each spring at the device [N/m]

  // Locks `x`, `x,z`, ... Throws std::invalid_argument.
  void ParseLocks(const std::string& text);
};

class OperatorMotion {
 public:
  // Situation is the input from the haptic loop at a tick.
  struct Situation {
    std::uint32_t epoch = 0;  // of the engagement; a change says that one begins at this reading
    bool engaged = false;     // the commands request that the tool follows
    bool follows = false;     // the slave accepted the epoch: `transform` belongs to it
    double dt = 0;            // [s]
  };

  // `stiffest`: largest stiffness that the device renders stably [N/m]. Contact, springs and lag
  // share it equally.
  OperatorMotion(const MotionOptions& options, double stiffest);

  // Returns a reading in the device's own axes D, in the master frame M. Real-time safe, like all
  // that follows.
  [[nodiscard]] DeviceReading ToMaster(const DeviceReading& reading_D) const noexcept {
    return options_.axes.ToMaster(reading_D);
  }
  [[nodiscard]] const AxisMap& axes() const noexcept { return options_.axes; }
  // Sets the position of the surface at the last command, frame M.
  void SetSurface(const DeviceGuide& surface) noexcept { surface_ = surface; }
  // Returns the guide of the surface along the device's axes.
  [[nodiscard]] DeviceGuide guide() const noexcept;
  [[nodiscard]] bool IsClutched(const DeviceReading& reading) const noexcept;
  // Position and velocity to command for `reading` [m], [m/s].
  DeviceReading Command(const DeviceReading& reading, const TeleopTransform& transform,
                        const Situation& now) noexcept;
  // Returns the force at the device for the contact's force `f_M` at the last command [N].
  [[nodiscard]] Eigen::Vector3d ForceAtDevice(const Eigen::Vector3d& f_M) const noexcept;
  // Returns whether the last command or its force differs from the device's.
  [[nodiscard]] bool is_active() const noexcept { return is_active_; }
  // Largest stiffness left for the contact [N/m].
  [[nodiscard]] double contact_stiffness() const noexcept { return contact_stiffness_; }

 private:
  void Begin(const Eigen::Vector3d& p_M, const TeleopTransform& transform) noexcept;
  // Adds the force of the fixtures at `p_M`.
  void Pull(const TeleopTransform& transform, const Eigen::Vector3d& p_M) noexcept;
  void LimitSpeed(double position_scale, double dt, DeviceReading* command) noexcept;
  void KeepInBox(const TeleopTransform& transform, DeviceReading* command) noexcept;
  [[nodiscard]] Eigen::Vector3d InBox(const Eigen::Vector3d& p_S) noexcept;

  MotionOptions options_;
  std::vector<FixtureSpring> springs_;
  ContactSpeed speed_;
  double contact_stiffness_, spring_stiffness_ = 0;  // [N/m]
  DeviceGuide surface_;
  std::uint32_t epoch_ = 0;
  bool has_begun_ = false;                                     // with the transform of this epoch
  Eigen::Vector3d engaged_at_{0, 0, 0};                        // M [m]
  Eigen::Vector3d box_lower_{0, 0, 0}, box_upper_{0, 0, 0};    // S [m], wider for a tool outside
  Eigen::Vector3d kept_M_{1, 1, 1};                            // 0: the axis of M is locked
  Eigen::Matrix3d through_box_ = Eigen::Matrix3d::Identity();  // of motion and force, frame M
  Eigen::Vector3d springs_force_{0, 0, 0};                     // M [N]
  bool is_active_ = false;
};

}  // namespace palpate
