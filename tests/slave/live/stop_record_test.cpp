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

TEST(StopRecordTest, TellsWhyAndSinceWhen) {
  StopRecord record;
  EXPECT_THAT(record.Words(), IsEmpty());
  EXPECT_THAT(record.Begin("by the operator, alice"), IsEmpty());
  EXPECT_THAT(record.Words(), MatchesRegex("emergency stop for [0-9] s: by the operator, alice"));
  record.End();
  EXPECT_THAT(record.Words(), IsEmpty());
}

TEST(StopRecordTest, AReasonMovesNoCursor) {
  StopRecord record;
  EXPECT_THAT(record.Begin("\x1b[2J" + std::string(1000, 'a')), IsEmpty());
  EXPECT_THAT(record.Words(), Not(HasSubstr("\x1b")));
  EXPECT_LT(record.Words().size(), 260U);
}

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

// The folder is gone, its disk full: the stop stands all the same, and outlives the process as soon
// as it can.
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

// A file that somebody else made stops, too, whatever it holds.
TEST_F(StopRecordFileTest, AFileWithoutAReasonStops) {
  std::ofstream(folder_ / "emergency-stop") << std::string(100000, 'x');
  StopRecord record;
  EXPECT_TRUE(record.KeepIn(folder_));
  EXPECT_THAT(record.Words(), HasSubstr(": from before the start"));
}

TEST_F(StopRecordFileTest, AFolderInItsPlaceIsRefused) {
  std::filesystem::create_directories(folder_ / "emergency-stop");
  EXPECT_THROW(StopRecord().KeepIn(folder_), std::runtime_error);
}

// Whoever plants a link can neither have its target overwritten nor hide the stop.
TEST_F(StopRecordFileTest, LinksAreNotFollowed) {
  const auto target = folder_ / "target", file = folder_ / "emergency-stop";
  std::ofstream(target) << "mine";
  std::filesystem::create_symlink(target, folder_ / "emergency-stop.part");
  StopRecord record;
  EXPECT_FALSE(record.KeepIn(folder_));
  std::filesystem::create_symlink(target, file);
  EXPECT_THAT(record.Begin("by a test"), IsEmpty());
  EXPECT_TRUE(std::filesystem::is_regular_file(std::filesystem::symlink_status(file)));
  EXPECT_TRUE(StopRecord().KeepIn(folder_));
  for (const char* planted : {"target", "nowhere"}) {
    std::filesystem::remove(file);
    std::filesystem::create_symlink(folder_ / planted, file);
    EXPECT_THROW(StopRecord().KeepIn(folder_), std::runtime_error) << planted;
  }
  EXPECT_EQ(std::filesystem::file_size(target), 4U);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "nowhere"));
}

TEST_F(StopRecordFileTest, AStopThatCannotBeKeptStillStops) {
  StopRecord record;
  EXPECT_FALSE(record.KeepIn(folder_));
  std::filesystem::remove_all(folder_);
  EXPECT_THAT(record.Begin("by a test"), HasSubstr("is not saved"));
  EXPECT_THAT(record.Words(), HasSubstr("by a test"));
}

}  // namespace
}  // namespace palpate
