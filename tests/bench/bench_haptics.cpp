// Cost of a haptic tick, per rendering mode, beside the cost of waking up for nothing. A tick
// should be a small part of the millisecond that it has; `bare_timer` is what any loop pays for the
// timer.
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

// A loop that follows, inside the contact, with a new state every other tick.
class Following {
 public:
  explicit Following(RenderMode mode) : loop_(OptionsFor(mode), {&states_, &commands_, &records_}) {
    for (int i = 0; i < 100; ++i) Tick();
  }
  Eigen::Vector3d Tick() {
    now_ += kHapticPeriod;
    if (++count_ % 2 == 0) states_.Put({Pressed(now_), now_, 0});
    DeviceReading reading;
    reading.engaged = count_ > 2;
    if (count_ > 10) reading.p_M.y() = -0.002 - 1e-6 * static_cast<double>(count_ % 7);
    const Eigen::Vector3d force = loop_.Tick(reading, now_);
    TickRecord drained;
    records_.Pop(&drained);
    return force;
  }
  [[nodiscard]] bool follows() const { return loop_.record().state == OperatorState::kFollowing; }

 private:
  static HapticLoop::Options OptionsFor(RenderMode mode) {
    HapticLoop::Options options;
    options.render = mode;
    return options;
  }

  LatestValue<ReceivedState> states_;
  LatestValue<OperatorCommand> commands_;
  SpscRing<TickRecord> records_{64};
  HapticLoop loop_;
  Time now_{std::chrono::hours(1)};
  std::int64_t count_ = 0;
};

void BM_Tick(benchmark::State& bench) {
  const auto mode = static_cast<RenderMode>(bench.range(0));
  Following following(mode);
  for (auto _ : bench) benchmark::DoNotOptimize(following.Tick());
  if (!following.follows()) bench.SkipWithError("not following");
  bench.SetLabel(std::string(ToString(mode)));
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
