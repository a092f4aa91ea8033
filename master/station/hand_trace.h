// End-to-end latency: the stages from the sample to the force of one tick.
#pragma once

#include <cstdint>
#include <optional>

#include "master/haptics/tick_record.h"
#include "shared/state/sample_trace.h"

namespace palpate {

// Duration of each stage [s]. Their sum is `total`.
struct HandTrace {
  std::uint64_t sample = 0, state = 0;  // numbers of the sample and of the state
  double t = 0;                         // of the tick, as in the log [s]
  double capture = 0;                   // from exposure or touch until the slave has the sample
  double eyes = 0;                      // vision or tactile processing
  double model = 0;
  double wait = 0;  // until the state is sent
  double wire = 0;  // by the clock offset, which may be wrong by half a round trip
  double tick = 0;  // from arrival of the state to the tick
  double total = 0;
};

// nullopt: the tick used no state, or a state of another sample.
std::optional<HandTrace> TraceOf(const TickRecord& tick, double t, const SampleTrace& sample);

}  // namespace palpate
