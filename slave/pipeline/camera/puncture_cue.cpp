#include "slave/pipeline/camera/puncture_cue.h"

#include <algorithm>

namespace palpate {

bool PunctureCue::Broke(const Sample& look) noexcept {
  deepest_ = std::max(deepest_, look.depth);
  if (!look.dent_known || look.expected_px < kLeastDent) return false;
  const double most = look.seen_px + kSigmas * look.sigma_px;
  const bool is_gone = most < kGone * look.expected_px;
  was_dented_ |= look.seen_px - kSigmas * look.sigma_px > kGone * look.expected_px;
  gone_ = is_gone ? gone_ + 1 : 0;
  const bool overshot = IsArmed(look.depth);
  const bool is_driven = look.depth > (1 - kRetreat) * deepest_;
  return overshot && is_driven && gone_ >= (was_dented_ ? 1 : kUnseenDent);
}

}  // namespace palpate
