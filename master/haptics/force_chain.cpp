#include "master/haptics/force_chain.h"

#include <cmath>

namespace palpate {
namespace {

constexpr std::array<std::string_view, kReasonCount> kNames{
    "not_following", "stale",     "unknown", "other_epoch", "fading",    "punctured", "blending",
    "beyond_model",  "passivity", "clamped", "not_finite",  "bad_state", "bad_device"};

}  // namespace

std::string_view ToString(Reason reason) {
  return kNames[static_cast<std::size_t>(reason)];
}

std::string ToString(const Reasons& reasons) {
  std::string text;
  for (std::size_t i = 0; i < kReasonCount; ++i) {
    if (!reasons.Has(static_cast<Reason>(i))) continue;
    if (!text.empty()) text += '+';
    text += kNames[i];
  }
  return text;
}

Eigen::Vector3d LimitForce(const Eigen::Vector3d& force, double limit, Reasons* reasons) noexcept {
  if (!force.allFinite() || !(limit >= 0)) {
    reasons->Add(Reason::kNotFinite);
    return {0, 0, 0};
  }
  const double size = force.stableNorm();  // squares of 1e300 overflow
  if (size <= limit) return force;
  reasons->Add(Reason::kClamped);
  return force / size * limit;
}

}  // namespace palpate
