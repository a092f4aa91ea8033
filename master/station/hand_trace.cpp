#include "master/station/hand_trace.h"

namespace palpate {

std::optional<HandTrace> TraceOf(const TickRecord& tick, double t, const SampleTrace& sample) {
  if (tick.sensed_age < 0 || tick.sensed_at != sample.sensed_at) return std::nullopt;
  HandTrace trace{.sample = sample.sample, .state = tick.state_sequence, .t = t};
  trace.capture = SecondsBetween(sample.sensed_at, sample.acquired_at);
  trace.eyes = SecondsBetween(sample.acquired_at, sample.processed_at);
  trace.model = SecondsBetween(sample.processed_at, sample.solved_at);
  trace.wait = SecondsBetween(sample.solved_at, tick.sent_at);
  trace.tick = tick.state_age;
  trace.total = tick.sensed_age;
  trace.wire = trace.total - trace.tick - SecondsBetween(sample.sensed_at, tick.sent_at);
  return trace;
}

}  // namespace palpate
