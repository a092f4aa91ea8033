#include "slave/simulator/presses/write_presses.h"

#include <filesystem>

#include <gtest/gtest.h>

#include "shared/text/csv.h"
#include "slave/capture/tactile_recording.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

TEST(WritePressesTest, WritesOneRecordingPerStartWithItsForces) {
  const Scratch scratch;
  ASSERT_EQ(WritePresses({.out = scratch.path() / "presses", .presses = 7}, {}), 0);
  const TactileRecording first =
      ReadTactileRecording(scratch.path() / "presses" / "start00001.csv", {});
  ASSERT_EQ(first.fingers.size(), 1U);
  EXPECT_TRUE(first.fingers[0].has_pac && first.fingers[0].has_pdc);
  EXPECT_NEAR(first.t[100], 1, 1e-9);
  const CsvTable table(scratch.path() / "presses" / "start00001.csv");
  EXPECT_TRUE(table.Find("fz"));
  EXPECT_TRUE(std::filesystem::exists(scratch.path() / "presses" / "start00002.csv"));
  EXPECT_FALSE(std::filesystem::exists(scratch.path() / "presses" / "start00003.csv"));
}

}  // namespace
}  // namespace palpate
