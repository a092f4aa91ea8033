// A hand that somebody leads with a mouse, a pen or keys on the station's page: what the page aims
// at, at a bounded speed, through an arm that gives way to the force. Whoever has no haptic device
// sees how far the hand stays behind the cursor.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include "master/device/arm.h"
#include "master/device/device.h"
#include "shared/link/latest_value.h"

namespace palpate {

// What the page says of its pointer.
struct PointerAim {
  Eigen::Vector3d p_M{0, 0, 0};  // from where the engagement began, frame M [m]
  std::uint64_t page = 0;        // that says so
  bool engaged = false;          // the button is held: the hand follows
  Time heard_at{};               // master's clock
  double stamp = 0;              // the page's own, given back by `used` once it moved the hand
};

class Pointer final : public Device {
 public:
  // A page that says nothing for so long holds nothing any more [s]: browsers on busy machines are
  // silent for 0.1 s and more again and again. Meanwhile the tool stands where it was aimed last,
  // as it does when it is let go.
  static constexpr double kSilence = 0.250;

  // `speed`: of the intent at most [m/s], > 0, which the arm overshoots by a fifth; else throws
  // std::invalid_argument.
  explicit Pointer(double speed, const Arm& arm = {});

  // What the page says now. One thread; finite numbers.
  void Aim(const PointerAim& aim) noexcept { aims_.Put(aim); }
  // The stamp of the newest aim that a reading has used; any thread.
  [[nodiscard]] double used() const noexcept { return used_; }

  // It holds the hand; any thread.
  [[nodiscard]] bool holds() const noexcept { return holds_; }

  // Engaging never moves the hand. Silence lets go, until the page has let go too and holds anew,
  // or another page holds: a page that comes back to life does not take the hand by itself.
  DeviceReading Read(Time now) noexcept override;
  void WriteForce(const Eigen::Vector3d& force_M) noexcept override { hand_.ApplyForce(force_M); }
  void Guide(const DeviceGuide& /*guide*/) noexcept override {}
  [[nodiscard]] bool finished() const noexcept override { return false; }
  [[nodiscard]] std::string description() const override;
  [[nodiscard]] double force_limit() const override { return 12; }

 private:
  void Take(Time now) noexcept;
  void MoveIntent(double dt) noexcept;

  const double speed_;  // [m/s]
  LatestValue<PointerAim> aims_;
  std::atomic<double> used_{0};
  std::atomic<bool> holds_{false};
  bool let_go_ = true;  // the page has, since silence did
  static_assert(std::atomic<double>::is_always_lock_free);
  PointerAim aim_;                      // the newest
  Eigen::Vector3d begin_{0, 0, 0};      // where the hand was when the engagement began [m]
  Eigen::Vector3d begin_aim_{0, 0, 0};  // and what was aimed at then [m]
  HandIntent intent_;
  MovingArm hand_;
  std::optional<Time> last_;
};

}  // namespace palpate
