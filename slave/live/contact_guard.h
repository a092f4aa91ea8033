// The guards on force and depth: they limit targets and retract the tool to the surface.
#pragma once

#include <optional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "shared/state/slave_state.h"
#include "slave/manipulator/manipulator.h"

namespace palpate {

// Targets end at this multiple of a guard.
inline constexpr double kFloor = 1.05;

// The present contact estimate. Frame S.
struct ContactState {
  std::optional<Eigen::Vector3d> force;  // of the object on the tool [N]; nullopt: unknown
  double depth = 0;                      // of the tool in the object [m]
  Eigen::Vector3d outward{0, 0, 0};      // of the surface touched [-]
  // Values at the present tip position according to the local model: magnitude of the force [N] (0:
  // unknown), and depth [m] (negative above the surface).
  double force_by_now = 0, depth_by_now = 0;
  // The surface of the local model: outward normal, zero: unknown; increase of the force with depth
  // [N/m], 0: unknown.
  Eigen::Vector3d normal{0, 0, 0};
  double stiffness = 0;
};

// Applies the guards. No target lies deeper than kFloor times a guard by the local model, so a late
// check of the guards does not let the tool go deeper. If guards retract, they move the tool back
// to the surface, even if the limit is detected after the disengagement. A fault of the arm delays
// the retreat; an arm that does not follow ends it. Positions are those of the encoders, frame S.
class ContactGuard {
 public:
  ContactGuard(Manipulator& manipulator, const ManipulatorOptions& limits)
      : manipulator_(manipulator), limits_(limits) {}

  // `follows`: the operator leads the tool. Continues a retreat. Returns whether the operator has
  // just led the tool beyond a guard.
  [[nodiscard]] bool Check(Time now, const ContactState& contact, bool follows) noexcept;
  // Plans the retreat to the surface if the guards retract. Sends no command yet.
  void BeginRetreat(Time now, const ContactState& contact) noexcept;
  void ContinueRetreat(Time now) noexcept;
  void EndRetreat() noexcept { retreat_.reset(); }
  [[nodiscard]] bool retreats() const noexcept { return retreat_.has_value(); }
  // Samples have not yet shown the effect of the last motion.
  [[nodiscard]] bool is_unseen() const noexcept { return unseen_; }

  // The nearest target that the guards permit; nullopt: this one leads deeper beyond a guard.
  [[nodiscard]] std::optional<Eigen::Vector3d> Permitted(const Eigen::Vector3d& target,
                                                         Events* events) const noexcept;
  // Distance of `p_S`, or of the nearest point in the workspace, from the tip [m].
  [[nodiscard]] double WayTo(const Eigen::Vector3d& p_S) const noexcept;

 private:
  void SetFloor(const ContactState& contact, double force) noexcept;

  Manipulator& manipulator_;
  const ManipulatorOptions& limits_;
  // Set when a guard is reached: targets move outwards only.
  std::optional<Eigen::Vector3d> outward_;
  std::optional<Eigen::Hyperplane<double, 3>> floor_;  // no target may be below it
  std::optional<Eigen::Vector3d> retreat_;             // where the tool retracts to [m]
  std::uint32_t retreat_frame_ = 0;                    // of the manipulator at that position
  Time retreat_until_{};
  Time followed_at_{};  // last
  bool unseen_ = false;
};

}  // namespace palpate
