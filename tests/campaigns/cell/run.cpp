#include "tests/campaigns/cell/run.h"

#include <algorithm>

#include "slave/simulator/environment/press_motion.h"

namespace palpate::campaign {

double Counts::WayAt(std::size_t index) const {
  if (index < rest) return 0;
  if (index < rest + in) {
    return MinimumJerk(static_cast<double>(index - rest + 1) / static_cast<double>(in));
  }
  if (index < rest + in + hold) return 1;
  const auto gone = static_cast<double>(index - (rest + in + hold) + 1);
  return MinimumJerk(std::max(0.0, 1 - gone / static_cast<double>(back)));
}

}  // namespace palpate::campaign
