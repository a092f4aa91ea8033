// The pointer device: mouse, pen, keys or gamepad on the operator's page set a target. The device
// follows it at a bounded speed through the arm model, so that it lags behind under force.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <optional>

#include "master/device/arm.h"
#include "master/device/haptic_device.h"
#include "shared/link/latest_value.h"

namespace palpate {

// Target that a page sends.
struct PointerAim {
  Eigen::Vector3d p_M{0, 0, 0};  // relative to the start of the engagement, frame M [m]
  std::uint64_t page = 0;        // the sender
  bool engaged = false;          // the button is pressed: the device follows
  Time received_at{};            // master's clock
  double stamp = 0;              // of the page, returned by `used` once it is applied
  double gap = 0;                // between two beats of the page's timer, see MaxSilence [s]
};

class Pointer final : public HapticDevice {
 public:
  // After this silence of the page the tool holds its position [s]: five periods of the page.
  static constexpr double kHoldAfter = 0.100;
  // Range of MaxSilence [s].
  static constexpr double kMinSilence = 0.250, kMaxSilence = 1.0;

  // Silence of a page after which the operator is disengaged [s]. `gap`: the longest time between
  // two beats of the page's timer in the last seconds, by the page's clock [s], >= 0.
  //
  // A browser on a busy machine is late by some tenths of a second, again and again, so that a
  // constant limit ends every engagement. The limit is twice what the browser itself has measured.
  // The link is not part of that: a link that gets worse does not prolong the limit.
  // The tool holds after kHoldAfter, whether the operator is disengaged or not. So the limit only
  // decides whether the tool continues without a new engagement when the page sends again. A person
  // whose act has no effect for more than a second turns to something else (Nielsen, Usability
  // Engineering, 1993), and the pressed button may no longer be meant. That bounds
  // the limit, whatever a page reports.
  [[nodiscard]] static double MaxSilence(double gap) noexcept {
    constexpr double kMargin = 2;
    return std::clamp(kMargin * gap, kMinSilence, kMaxSilence);
  }

  // `speed` > 0: largest speed of the intent [m/s]; the arm overshoots it by a fifth. Throws
  // std::invalid_argument otherwise.
  explicit Pointer(double speed, const Arm& arm = {});

  // Sets the newest target, with finite numbers. Called by one thread.
  void Aim(const PointerAim& aim) noexcept { aims_.Put(aim); }
  // Returns the silence of the page that ended the last engagement [s]. 0: it did not end so.
  // Thread-safe.
  [[nodiscard]] double silence() const noexcept { return silence_; }
  // The stamp of the newest target that a reading has used. Thread-safe.
  [[nodiscard]] double used() const noexcept { return used_; }

  // Returns whether the device is engaged. Thread-safe.
  [[nodiscard]] bool holds() const noexcept { return holds_; }

  [[nodiscard]] std::string description() const override;

 protected:
  // Engaging never moves the device. After a timeout the device stays disengaged until the page has
  // disengaged and engages again, or another page engages.
  DeviceReading DoRead(Time now) noexcept override;
  DeviceOutput DoWrite(const Wrench& wrench) noexcept override;

 private:
  void TakeAim(Time now) noexcept;
  void MoveIntent(Time now, double dt) noexcept;

  const double speed_;  // [m/s]
  LatestValue<PointerAim> aims_;
  std::atomic<double> used_{0}, silence_{0};
  std::atomic<bool> holds_{false};
  bool let_go_ = true;  // the page has disengaged since the last timeout
  static_assert(std::atomic<double>::is_always_lock_free);
  PointerAim aim_;                      // the newest
  Eigen::Vector3d begin_{0, 0, 0};      // device position at the start of the engagement [m]
  Eigen::Vector3d begin_aim_{0, 0, 0};  // target at the start of the engagement [m]
  HandIntent intent_;
  MovingArm hand_;
  std::optional<Time> last_;
};

}  // namespace palpate
