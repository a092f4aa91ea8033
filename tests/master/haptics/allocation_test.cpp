// Counts what the haptic loop takes from the heap: it must be nothing.
#include <atomic>
#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/master/haptics/rig.h"
#include "tests/master/haptics/wall_patch.h"

namespace {

std::atomic<bool> g_counting{false};
std::atomic<int> g_allocations{0};

void* Allocate(std::size_t size) {
  if (g_counting) ++g_allocations;
  void* memory = std::malloc(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

}  // namespace

void* operator new(std::size_t size) {
  return Allocate(size);
}
void* operator new[](std::size_t size) {
  return Allocate(size);
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete[](void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete[](void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace palpate {
namespace {

// Ten thousand ticks with everything that happens: engaging, pressing, a changed model, silence,
// an unknown force, letting go.
TEST(AllocationTest, TenThousandTicksAllocateNothing) {
  for (const RenderMode mode : {RenderMode::kLocal, RenderMode::kInterpolate, RenderMode::kHold}) {
    Rig rig({}, mode);
    SimHand hand(0.005, 0.02);
    int followed = 0;
    for (int tick = 0; tick < 10000; ++tick) {
      rig.now += kHapticPeriod;
      rig.slave.silent = tick > 5200 && tick < 5400;
      rig.slave.validity = tick > 9100 ? Validity::kTrackingLost : Validity::kValid;
      if (tick % 700 == 0) rig.slave.set_K(400 + tick % 300);
      if (tick % 1300 == 600) rig.patches.Put(WallPatch(400, static_cast<std::uint32_t>(tick)));
      rig.slave.Step(rig.now, &rig.commands, &rig.states);
      g_counting = true;
      const DeviceReading reading = hand.Read(rig.now);
      hand.WriteForce(rig.loop.Tick(reading, rig.now));
      hand.Guide(rig.loop.guide());
      g_counting = false;
      if (rig.state() == OperatorState::kFollowing) ++followed;
    }
    EXPECT_GT(followed, 3000) << "the test did not exercise the loop";
    EXPECT_EQ(g_allocations, 0) << ToString(mode);
  }
}

TEST(AllocationTest, TheCounterCounts) {
  const int before = g_allocations;
  g_counting = true;
  const auto value = std::make_unique<int>(1);
  g_counting = false;
  EXPECT_GT(g_allocations, before);
}

}  // namespace
}  // namespace palpate
