// From the slave's states to the force at this millisecond, in one of three ways.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "master/haptics/delayed_linear.h"
#include "master/haptics/force_chain.h"
#include "master/haptics/local_contact.h"
#include "shared/state/slave_state.h"

namespace palpate {

enum class RenderMode : std::uint8_t {
  kLocal,        // the one-sided local model at the newest hand position (LocalContact)
  kInterpolate,  // the last forces, a period late (DelayedLinear)
  kHold,         // the newest force until the next
};
std::string_view ToString(RenderMode mode);  // `local`, `interpolate`, `hold`
std::optional<RenderMode> ParseRenderMode(std::string_view text);

class Renderer {
 public:
  explicit Renderer(RenderMode mode) : mode_(mode) {}

  // Takes a new state that was `sensed` and `arrived` then, now being `now`: all on the master's
  // clock [s]. States that repeat what was sensed count once. Real-time safe.
  void Take(const SlaveState& state, double sensed, double arrived, double now) noexcept;
  // Force of the object on the tool at `p_S`, S [N], with what became of it. Real-time safe.
  Eigen::Vector3d Render(const Eigen::Vector3d& p_S, double now, Reasons* reasons) noexcept;
  // Forgets the forces, keeps the surface: before a new engagement. Real-time safe.
  void ForgetForces() noexcept {
    samples_.Clear();
    contact_.LetGo();
  }
  [[nodiscard]] const LocalContact& contact() const noexcept { return contact_; }

 private:
  static constexpr double kPunctureTime = 0.010;  // to zero when the tool breaks through [s]
  static constexpr double kReturnTime = 0.050;    // and back when it is clear [s]

  RenderMode mode_;
  LocalContact contact_;
  DelayedLinear samples_;
  bool punctured_ = false;
  double presence_ = 1;  // 0: punctured, 1: intact
  double last_ = 0;      // the tick before [s]
};

}  // namespace palpate
