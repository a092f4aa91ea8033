#include "slave/simulator/presses/train.h"

#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "shared/text/csv.h"
#include "slave/capture/tactile_recording.h"
#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(TrainCommandTest, WritesOneRecordingPerStartWithItsForces) {
  const Scratch scratch;
  ASSERT_EQ(RunTrain({.data = "simulated", .out = scratch.path() / "presses", .presses = 7}, {}),
            0);
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

std::string Complaint(const TrainOptions& options) {
  try {
    RunTrain(options, {});
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "nothing";
}

TEST(TrainCommandTest, OtherDataAreRefusedWithTheCommandThatTrains) {
  const Scratch scratch;
  const auto out = scratch.path() / "out";
  EXPECT_THAT(
      Complaint({.data = "day1.csv", .out = out}),
      HasSubstr("day1.csv: expected simulated. Networks are trained by `python3 -m palpate.train"));
  EXPECT_THAT(Complaint({.data = "simulated", .out = out, .presses = 0}), HasSubstr("1 or more"));
  EXPECT_THAT(Complaint({.data = "simulated", .out = out, .seed = -1}), HasSubstr("--seed -1"));
  EXPECT_FALSE(std::filesystem::exists(out));
}

}  // namespace
}  // namespace palpate
