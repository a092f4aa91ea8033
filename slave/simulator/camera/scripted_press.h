// Motion of the tool for runs without an operator: straight ahead from home into the body, a hold,
// and back, repeated as requested.
#pragma once

#include <Eigen/Core>

#include "slave/capture/frame_source.h"
#include "slave/scene/scene.h"
#include "slave/simulator/camera/simulated_site.h"
#include "slave/simulator/environment/press_motion.h"

namespace palpate {

// Each press: from manipulator.home along tool.direction to operator.press.depth beyond the true
// surface (misplacement included) in a minimum-jerk ramp whose peak speed is operator.press.speed,
// or manipulator.max_speed if that is less; a hold of 1 s, or longer, so that it lasts at least a
// third of the contact; the same ramp back; a rest of 0.5 s at home.
//
//   p(u) = start + way (10 u^3 - 15 u^4 + 6 u^5),   u = t / T,   peak speed 15/8 |way| / T
//
// Source: Flash & Hogan, J. Neurosci. 5 (1985), minimum-jerk motion.
class ScriptedPress {
 public:
  static constexpr double kHold = 1.0;  // [s]
  static constexpr double kRest = 0.5;  // [s]

  // Throws std::invalid_argument naming the key: no tool, nothing in front of it, home inside the
  // body, depth or speed not positive; see also TrueBody. With an embryo it moves straight to the
  // target, independent of the depth.
  explicit ScriptedPress(const Scene& scene, int presses = 1);

  // Where the tip is at `t` [s] after the start, S [m]; home before, after, and for NaN.
  [[nodiscard]] Eigen::Vector3d Tip(double t) const noexcept {
    return home_ + motion_.At(t) * way_;
  }
  [[nodiscard]] double duration() const noexcept { return motion_.duration(); }  // [s]
  // For the first contact, from the start [s].
  [[nodiscard]] double contact_begin() const noexcept { return motion_.ramp * touch_; }
  [[nodiscard]] double contact_end() const noexcept {
    return 2 * motion_.ramp + motion_.hold - motion_.ramp * touch_;
  }
  [[nodiscard]] double hold_begin() const noexcept { return motion_.ramp; }
  [[nodiscard]] double hold_end() const noexcept { return motion_.ramp + motion_.hold; }
  [[nodiscard]] double gap() const noexcept { return gap_; }  // home to true surface [m]

 private:
  Eigen::Vector3d home_;  // S [m]
  Eigen::Vector3d way_;   // home to peak, S [m]
  double gap_ = 0;
  double touch_ = 0;  // part of the ramp's time at which the surface is met
  PressMotion motion_;
};

// A simulator with scripted contacts, image after image on its own clock: the source of `process`
// without a recording.
class ScriptedCamera : public FrameSource {
 public:
  // `site` of that scene must outlive this. Throws the exceptions of ScriptedPress.
  ScriptedCamera(SimulatedSite& site, const Scene& scene);
  std::optional<Frame> Next(const std::stop_token& stop) override;
  [[nodiscard]] std::string description() const override;

 private:
  SimulatedSite& site_;
  ScriptedPress press_;
  double rate_;  // [Hz]
  std::uint64_t sequence_ = 0;
};

}  // namespace palpate
