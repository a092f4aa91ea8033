#include "slave/live/planned_depth.h"

#include <algorithm>
#include <utility>

#include "shared/text/text.h"

namespace palpate {

std::string PlannedDepth::Update(const ContactEstimate& estimate, bool touches) {
  if (touches) {
    if (IsForceKnown(estimate)) deepest_ = std::max(deepest_, estimate.depth);
    return {};
  }
  const double depth = std::exchange(deepest_, 0);
  if (!(depth > reported_)) return {};
  reported_ = depth;
  return Formatted(
      "pressed deeper than planned: %.3g mm, operator.press.depth is %.3g mm: run `study`",
      1e3 * depth, 1e3 * planned_);
}

}  // namespace palpate
