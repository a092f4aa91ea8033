#include "master/station/tick_digest.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace palpate {

double TickDigest::Add(const TickRecord& tick) {
  const std::scoped_lock lock(mutex_);
  if (!moment_.any && moment_.begin == Time{}) moment_.begin = tick.at;
  const double since_last =
      moment_.any ? std::max(0.0, SecondsBetween(moment_.newest.at, tick.at)) : kPeriod;
  moment_.t = SecondsBetween(moment_.begin, tick.at);
  if (!std::exchange(moment_.any, true)) second_since_ = sample_since_ = moment_.t;
  moment_.newest = tick;
  if (tick.round_trip > 0) moment_.round_trip = tick.round_trip;
  Count(tick, since_last);
  Sample(tick, since_last);
  return moment_.t;
}

void TickDigest::Restart(Time begin) {
  const std::scoped_lock lock(mutex_);
  moment_ = {};
  moment_.begin = begin;
  open_ = {};
  samples_.clear();
  seconds_.clear();
  second_ = {};
}

TickDigest::Moment TickDigest::Newest() const {
  const std::scoped_lock lock(mutex_);
  Moment moment = moment_;
  const auto count = std::min(std::ssize(samples_), kSamplesOfMoment);
  moment.samples.assign(samples_.end() - count, samples_.end());
  return moment;
}

std::vector<TickSample> TickDigest::Past() const {
  const std::scoped_lock lock(mutex_);
  return {samples_.begin(), samples_.end()};
}

// A deadline is missed if the next tick is more than half a period late.
void TickDigest::Count(const TickRecord& tick, double since_last) {
  moment_.missed += static_cast<std::uint64_t>(std::max(0.0, std::round(since_last / kPeriod) - 1));
  ++second_.ticks;
  if (tick.state_age > kLate) ++second_.late;
  const double passed = moment_.t - second_since_;
  if (passed < 1) return;
  moment_.rate = second_.ticks / passed;
  second_since_ = moment_.t;
  seconds_.push_back(std::exchange(second_, {}));
  if (seconds_.size() > kSeconds) seconds_.pop_front();
  Second sum;
  for (const Second& second : seconds_) {
    sum.ticks += second.ticks;
    sum.late += second.late;
  }
  moment_.late_share = static_cast<double>(sum.late) / sum.ticks;
}

void TickDigest::Sample(const TickRecord& tick, double since_last) {
  open_.t = moment_.t;
  open_.scaled = tick.chain.scaled.norm();
  open_.sent = std::max(open_.sent, tick.chain.sent.norm());
  open_.p_M = tick.p_M;
  open_.energy = tick.energy;
  open_.p_S = tick.p_S_tip.hasNaN() ? tick.p_S_tip : tick.p_S;  // NaN before the first state
  open_.p_S_tip = tick.p_S_tip;
  open_.age = std::max(open_.age, tick.state_age);
  open_.round_trip = moment_.round_trip;
  open_.longest_tick = std::max(open_.longest_tick, since_last);
  if (moment_.t - sample_since_ < kSampleEvery) return;
  sample_since_ = moment_.t;
  samples_.push_back(open_);
  if (samples_.size() > kSamplesKept) samples_.pop_front();
  open_ = {.number = open_.number + 1};
}

std::optional<HandTrace> TraceOf(const TickRecord& tick, double t, const SampleTrace& sample) {
  if (tick.sensed_age < 0 || tick.sensed_at != sample.sensed_at) return std::nullopt;
  HandTrace trace{.sample = sample.sample, .state = tick.state_sequence, .t = t};
  trace.capture = SecondsBetween(sample.sensed_at, sample.acquired_at);
  trace.sensing = SecondsBetween(sample.acquired_at, sample.processed_at);
  trace.model = SecondsBetween(sample.processed_at, sample.solved_at);
  trace.wait = SecondsBetween(sample.solved_at, tick.sent_at);
  trace.tick = tick.state_age;
  trace.total = tick.sensed_age;
  trace.wire = trace.total - trace.tick - SecondsBetween(sample.sensed_at, tick.sent_at);
  return trace;
}

}  // namespace palpate
