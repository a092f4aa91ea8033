// Cost of a haptic tick, per rendering mode, beside the cost of waking up for nothing. A tick
// should be a small part of the millisecond that it has; `bare_timer` is what any loop pays for the
// timer.
#include <array>

#include <benchmark/benchmark.h>

#include "master/haptics/haptic_loop.h"
#include "master/haptics/periodic.h"

namespace palpate {
namespace {

SlaveState Pressed(Time sensed) {
  SlaveState state;
  state.sensed_at = sensed;
  state.sent_at = sensed;
  state.force = Eigen::Vector3d(0, 1, 0);
  state.true_force = state.force;
  state.validity = Validity::kValid;
  state.phase = Phase::kFollowing;
  state.epoch = 1;
  state.local_model.stiffness(1, 1) = 500;
  state.local_model.revision = 1;
  return state;
}

// Following inside the contact, a new state every other tick.
void BM_Tick(benchmark::State& bench) {
  LatestValue<ReceivedState> states;
  LatestValue<OperatorCommand> commands;
  SpscRing<TickRecord> records(4096);
  HapticLoop::Options options;
  options.render = static_cast<RenderMode>(bench.range(0));
  HapticLoop loop(options, {&states, &commands, &records});
  Time now{std::chrono::hours(1)};
  DeviceReading reading;
  TickRecord drained;
  std::int64_t tick = 0;
  for (auto _ : bench) {
    now += kHapticPeriod;
    if (++tick % 2 == 0) states.Put({Pressed(now), now, 0});
    reading.engaged = tick > 2;
    reading.p_M.y() = tick > 10 ? -0.002 - 1e-6 * static_cast<double>(tick % 7) : 0;
    benchmark::DoNotOptimize(loop.Tick(reading, now));
    records.Pop(&drained);
  }
  if (loop.record().state != OperatorState::kFollowing) bench.SkipWithError("not following");
  bench.SetLabel(std::string(ToString(options.render)));
}
BENCHMARK(BM_Tick)->DenseRange(0, 2);

// One period of an empty loop: CPU time is what the timer costs, wall time is the millisecond.
void BM_BareTimer(benchmark::State& bench) {
  Time wake = Clock::now();
  for (auto _ : bench) {
    wake += kHapticPeriod;
    WaitUntil(wake);
  }
  bench.SetLabel("bare_timer");
}
BENCHMARK(BM_BareTimer);

}  // namespace
}  // namespace palpate

BENCHMARK_MAIN();
