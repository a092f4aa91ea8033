// From the photon to the hand: the stages that made the force of one tick.
#pragma once

#include <cstdint>
#include <optional>

#include "master/haptics/record/tick_record.h"
#include "shared/state/sample_trace.h"

namespace palpate {

// Each stage from the end of the one before it [s]; together they are `total`.
struct HandTrace {
  std::uint64_t sample = 0, state = 0;  // numbers of the picture or sample, and of the state
  double t = 0;                         // of the tick, as in the log [s]
  double capture = 0;                   // from light or touch until the slave had it
  double eyes = 0;                      // or fingertips
  double model = 0;
  double wait = 0;  // until the state left that the tick went by
  double wire = 0;  // by the clocks' offset, which half a round trip may be wrong
  double tick = 0;  // since that state came
  double total = 0;
};

// nullopt: the tick went by no state, or by one of another sample than `sample`.
std::optional<HandTrace> TraceOf(const TickRecord& tick, double t, const SampleTrace& sample);

}  // namespace palpate
