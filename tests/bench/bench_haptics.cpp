// Cost of a haptic tick, per rendering mode, beside the cost of waking up for nothing. A tick
// should be a small part of the millisecond that it has; `bare_timer` is what any loop pays for the
// timer.
#include <algorithm>
#include <cmath>

#include <benchmark/benchmark.h>

#include "master/haptics/haptic_loop.h"
#include "master/haptics/periodic.h"
#include "shared/patch/patch_contact.h"

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

// A strip of `cells` lines, nodes at its first vertices, `tools` pressed into it all at once and
// moved at each tick.
void BM_PatchContact(benchmark::State& bench) {
  const auto cells = static_cast<int>(bench.range(0)), tools = static_cast<int>(bench.range(1));
  SurfacePatch patch;
  patch.epoch = 1;
  patch.cell_count = cells;
  patch.vertex_count = cells + 1;
  patch.node_count = std::min(cells + 1, kPatchNodes);
  for (int i = 0; i <= cells; ++i) {
    const auto at = static_cast<std::size_t>(i);
    patch.vertices[at] = {1e-3F * static_cast<float>(cells - i), 0, 0};
    patch.node_of[at] = static_cast<std::uint8_t>(i % patch.node_count);
    if (i < cells) {
      patch.cells[at] = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i + 1), 0};
    }
  }
  patch.coupled = true;
  patch.compliance.setConstant(3 * patch.node_count, 3 * patch.node_count, 1e-4F);
  patch.compliance.diagonal().setConstant(2e-3F);
  patch.full_depth = patch.valid_depth = 5e-3;
  patch.tool_count = tools;
  for (int i = 0; i < tools; ++i) {
    patch.tools[static_cast<std::size_t>(i)].centre.x() = 1e-4 * cells * (i - 2);
  }
  MarkRim(&patch);
  PatchLaw law;
  law.epoch = law.revision = 1;
  PatchContact contact;
  contact.Take(patch, law, 0, 0);
  int tick = 0;
  for (auto _ : bench) {
    const double depth = 2e-3 * std::sin(1e-2 * ++tick);
    benchmark::DoNotOptimize(contact.ForceAt({5e-4 * cells, -depth, 0}, 1, 1));
  }
  bench.SetLabel("patch, cells x tools");
}
BENCHMARK(BM_PatchContact)->ArgsProduct({{8, 64, 200}, {1, 5}});

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
