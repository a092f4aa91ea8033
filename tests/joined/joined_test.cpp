// Tests the complete path of commands and states between master and slave, with random schedules on
// one clock.
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "tests/joined/schedule.h"

namespace palpate {
namespace {

// A stop reaches the tool and is confirmed, a command acts once, the force fades when states are
// too old for the loop, settings change as a whole, a stop survives every reset, and after a fault
// of the device there is no force until a new engagement.
void ExpectNoViolation(std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t seed = from; seed < to; ++seed) {
    const std::string violation = Schedule(seed).Run();
    ASSERT_EQ(violation, "") << "seed " << seed;
  }
}

TEST(JoinedTest, NoScheduleViolatesAnInvariant) {
  ExpectNoViolation(0, 300);
}

TEST(JoinedSlowTest, NoScheduleOfTenThousandViolatesAnInvariant) {
  ExpectNoViolation(300, 10300);
}

}  // namespace
}  // namespace palpate
