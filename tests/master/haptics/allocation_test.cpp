// Counts the heap allocations of the haptic loop; there must be none.
#include <memory>

#include <gtest/gtest.h>

#include "master/device/sim_hand.h"
#include "tests/master/haptics/rig.h"
#include "tests/master/haptics/wall_patch.h"
#include "tests/support/allocation_count.h"

namespace palpate {
namespace {

TEST(AllocationTest, TheCounterCounts) {
  const long before = AllocationCount(), own = OwnAllocationCount();
  const auto value = std::make_unique<int>(1);
  EXPECT_GT(AllocationCount(), before);
  EXPECT_EQ(OwnAllocationCount(), own + 1);
}

// Ten thousand ticks with all events: engaging, pressing, a changed model, a silent slave, an
// unknown force, releasing.
TEST(AllocationTest, TenThousandTicksAllocateNothing) {
  for (const RenderMode mode : {RenderMode::kLocal, RenderMode::kInterpolate, RenderMode::kHold}) {
    Rig rig({}, mode);
    SimHand hand(0.005, 0.02);
    int followed = 0;
    long taken = 0;
    for (int tick = 0; tick < 10000; ++tick) {
      rig.now += kHapticPeriod;
      rig.slave.silent = tick > 5200 && tick < 5400;
      rig.slave.validity = tick > 9100 ? Validity::kTrackingLost : Validity::kValid;
      if (tick % 700 == 0) rig.slave.set_K(400 + tick % 300);
      if (tick % 1300 == 600) rig.patches.Put(WallPatch(400, static_cast<std::uint32_t>(tick)));
      rig.slave.Step(rig.now, &rig.commands, &rig.states);
      const long before = AllocationCount();
      const DeviceReading reading = hand.Read(rig.now);
      hand.WriteForce(rig.loop.Tick(reading, rig.now));
      hand.Guide(rig.loop.motion().guide());
      taken += AllocationCount() - before;
      if (rig.state() == OperatorState::kFollowing) ++followed;
    }
    EXPECT_GT(followed, 3000) << "the test did not exercise the loop";
    EXPECT_EQ(taken, 0) << ToString(mode);
  }
}

}  // namespace
}  // namespace palpate
