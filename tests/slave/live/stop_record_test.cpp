#include "slave/live/stop_record.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch.h"

namespace palpate {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::MatchesRegex;

using StopRecordFileTest = FolderTest;

TEST_F(StopRecordFileTest, OutlivesTheProcess) {
  {
    StopRecord first;
    EXPECT_FALSE(first.KeepIn(folder_));
    EXPECT_THAT(first.Begin("by the operator"), IsEmpty());
  }
  for (int restart = 0; restart < 2; ++restart) {
    StopRecord next;
    EXPECT_TRUE(next.KeepIn(folder_));
    EXPECT_THAT(
        next.Words(),
        MatchesRegex("emergency stop for [0-9]+ s: by the operator, from before the start"));
    if (restart == 1) next.End();
  }
  EXPECT_FALSE(StopRecord().KeepIn(folder_));
}

// The folder is missing or its disk is full: the stop stays active, and its record is written as
// soon as possible.
TEST_F(StopRecordFileTest, IsKeptAsSoonAsItCanBe) {
  StopRecord record;
  record.set_again(std::chrono::milliseconds(5));
  EXPECT_FALSE(record.KeepIn(folder_));
  std::filesystem::remove_all(folder_);
  EXPECT_THAT(record.Begin("by the operator"), HasSubstr("is not saved"));
  EXPECT_THAT(record.Words(), HasSubstr("by the operator"));
  std::filesystem::create_directories(folder_);
  for (int i = 0; i < 2000 && !std::filesystem::exists(folder_ / "emergency-stop"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_TRUE(StopRecord().KeepIn(folder_));
  record.End();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(StopRecord().KeepIn(folder_)) << "and is over when it is over";
}

// If the record could not be written there is nothing to remove: the stop can be reset.
TEST_F(StopRecordFileTest, AStopThatCouldNotBeSavedEndsWithoutAFile) {
  StopRecord record;
  EXPECT_FALSE(record.KeepIn(folder_));
  std::filesystem::remove_all(folder_);
  std::ofstream(folder_) << "no folder";
  EXPECT_THAT(record.Begin("by the operator"), HasSubstr("is not saved"));
  record.End();
  EXPECT_FALSE(record.is_active());
}

// A file made by another program also stops the tool, whatever its content.
TEST_F(StopRecordFileTest, AFileWithoutAReasonStops) {
  std::ofstream(folder_ / "emergency-stop") << std::string(100000, 'x');
  StopRecord record;
  EXPECT_TRUE(record.KeepIn(folder_));
  EXPECT_THAT(record.Words(), HasSubstr(": from before the start"));
}

}  // namespace
}  // namespace palpate
