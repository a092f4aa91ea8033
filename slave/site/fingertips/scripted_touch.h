// A simulator with scripted contacts, sample after sample on its own clock: the source of runs
// without an operator.
#pragma once

#include <cstdint>

#include "slave/capture/tactile_frame.h"
#include "slave/site/environment/press_motion.h"
#include "slave/site/fingertips/tactile_site.h"

namespace palpate {

// First a rest at home, while the baseline is measured and for 0.2 s more. Each contact: along
// TactileSite::approach() to operator.press.depth beyond the first contact in a minimum-jerk ramp
// whose peak speed is operator.press.speed, or manipulator.max_speed if that is less; a hold of 1
// s; the same ramp back; 0.5 s at home.
class ScriptedTouch final : public TactileSource {
 public:
  static constexpr double kSettle = 0.2, kHold = 1.0, kRest = 0.5;  // [s]

  // `site` of that scene must outlive this. Throws std::invalid_argument naming the key: nothing in
  // front of the fingers, depth or speed not positive.
  ScriptedTouch(TactileSite& site, const Scene& scene, int presses = 1);

  // As fast as it can be computed; sensed_at counts from Time{}. Ends after the last contact.
  std::optional<TactileFrame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

  // Where the tip is at `t` [s] after the start, S [m].
  [[nodiscard]] Eigen::Vector3d Tip(double t) const noexcept {
    return site_.home() + motion_.At(t - start_) * way_;
  }
  [[nodiscard]] double duration() const noexcept { return start_ + motion_.duration(); }  // [s]
  // For the first contact, from the start [s].
  [[nodiscard]] double hold_begin() const noexcept { return start_ + motion_.ramp; }
  [[nodiscard]] double hold_end() const noexcept { return start_ + motion_.ramp + kHold; }

 private:
  TactileSite& site_;
  double rate_;          // [Hz]
  Eigen::Vector3d way_;  // home to deepest, S [m]
  double start_ = 0;     // of the first contact [s]
  PressMotion motion_;
  std::uint64_t sequence_ = 0;
};

}  // namespace palpate
