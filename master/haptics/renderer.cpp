#include "master/haptics/renderer.h"

#include <algorithm>

namespace palpate {

std::string_view ToString(RenderMode mode) {
  switch (mode) {
    case RenderMode::kLocal:
      return "local";
    case RenderMode::kInterpolate:
      return "interpolate";
    case RenderMode::kHold:
      break;
  }
  return "hold";
}

std::optional<RenderMode> ParseRenderMode(std::string_view text) {
  for (const RenderMode mode : {RenderMode::kLocal, RenderMode::kInterpolate, RenderMode::kHold}) {
    if (text == ToString(mode)) return mode;
  }
  return std::nullopt;
}

void Renderer::Take(const SlaveState& state, double sensed, double arrived, double now) noexcept {
  if (IsForceKnown(state.validity)) punctured_ = state.validity == Validity::kPunctured;
  contact_.Take(state.local_model, now);
  if (IsForceKnown(state.validity) && state.force) {
    samples_.Add(sensed, std::max(sensed, arrived), *state.force);
  }
}

Eigen::Vector3d Renderer::Render(const Eigen::Vector3d& p_S, double now,
                                 Reasons* reasons) noexcept {
  const double dt = std::max(0.0, now - last_);
  last_ = now;
  presence_ = punctured_ ? std::max(0.0, presence_ - dt / kPunctureTime)
                         : std::min(1.0, presence_ + dt / kReturnTime);
  if (presence_ < 1) reasons->Add(Reason::kPunctured);
  if (mode_ == RenderMode::kHold) return presence_ * samples_.newest();
  if (mode_ == RenderMode::kInterpolate) return presence_ * samples_.At(now);
  if (contact_.IsBlending(now)) reasons->Add(Reason::kBlending);
  if (contact_.IsBeyond(p_S)) reasons->Add(Reason::kBeyondModel);
  return presence_ * contact_.ForceAt(p_S, now);
}

}  // namespace palpate
