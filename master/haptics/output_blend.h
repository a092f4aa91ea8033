// The last station before the device: goes over from what the hand feels now to what it shall feel,
// never in a step. Always between the two, hence within the limit if both are.
#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace palpate {

class OutputBlend {
 public:
  enum class Target : std::uint8_t {
    kZero,      // nothing
    kRendered,  // what is given to Step
    kFrozen,    // what was sent when this began
  };
  // From what was sent last to `target` in `duration` [s] >= 0. Real-time safe.
  void Go(Target target, double duration) noexcept;
  // The force to send [N], `dt` [s] after the last. Real-time safe.
  Eigen::Vector3d Step(const Eigen::Vector3d& rendered, double dt) noexcept;
  [[nodiscard]] bool is_blending() const noexcept { return elapsed_ < duration_; }

 private:
  Target target_ = Target::kZero;
  Eigen::Vector3d from_{0, 0, 0}, sent_{0, 0, 0};
  double duration_ = 0, elapsed_ = 0;
};

}  // namespace palpate
