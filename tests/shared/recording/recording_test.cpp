#include "shared/recording/recording.h"

#include <atomic>
#include <cmath>
#include <map>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "palpate/v1/recording.pb.h"

#include "shared/recording/npy.h"
#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RecordingTest : public ::testing::Test {
 protected:
  ~RecordingTest() override { std::filesystem::remove(file_); }

  const std::filesystem::path file_ = std::filesystem::temp_directory_path() /
                                      ("recording-test." + std::to_string(getpid()) + ".mcap");
};

TEST_F(RecordingTest, KeepsTheOrderOfEachThreadAndLosesNothing) {
  constexpr std::uint64_t kEach = 2000;
  {
    Recording recording({.file = file_});
    const auto a = recording.Open("/a", v1::FeltState()), b = recording.Open("/b", v1::FeltState());
    const auto put = [&](std::uint16_t channel) {
      for (std::uint64_t i = 1; i <= kEach; ++i) {
        v1::FeltState state;
        state.set_sample(i);
        recording.Put(channel, FromNanoseconds(i), state);
      }
    };
    const std::jthread first(put, a), second(put, b);
  }
  RecordingReader reader(file_);
  std::map<std::string, std::uint64_t> newest;
  for (v1::FeltState state; reader.Next();) {
    reader.Read(&state);
    EXPECT_EQ(state.sample(), ++newest[std::string(reader.topic())]);
    EXPECT_EQ(Nanoseconds(reader.at()), state.sample());
  }
  EXPECT_EQ(newest, (std::map<std::string, std::uint64_t>{{"/a", kEach}, {"/b", kEach}}));
  EXPECT_TRUE(reader.mcap().is_whole());
}

TEST_F(RecordingTest, WhatIsMadeLateIsMadeByAnotherThread) {
  std::atomic<bool> elsewhere{false};
  const auto here = std::this_thread::get_id();
  {
    Recording recording({.file = file_});
    const auto a = recording.Open("/a", v1::FeltState());
    std::atomic<bool> made{false};
    recording.Put(a, Clock::now(), 10, [&] {
      elsewhere = std::this_thread::get_id() != here;
      made = true;
      return std::string();
    });
    while (!made) std::this_thread::yield();
  }
  EXPECT_TRUE(elsewhere);
}

// More than may wait at all is never taken, so that memory is bounded; and it is said.
TEST_F(RecordingTest, WhatCannotWaitIsCountedAndSaid) {
  Recording recording({.file = file_, .most_waiting = 1000});
  const auto a = recording.Open("/a", v1::FeltState());
  recording.Put(a, Clock::now(), 5000, [] { return std::string(); });
  EXPECT_EQ(recording.stats().dropped, 1U);
  EXPECT_THAT(recording.stats().trouble, HasSubstr("1 messages are missing"));
  recording.Finish();
  RecordingReader reader(file_);
  EXPECT_FALSE(reader.Next());
  EXPECT_EQ(reader.mcap().notes().at("dropped").at("messages"), "1");
}

TEST_F(RecordingTest, ItsEndIsToldOnceInWords) {
  int told = 0;
  Recording recording({.file = file_, .limit = 100'000, .tell = [&](const std::string& why) {
                         ++told;
                         EXPECT_THAT(why, HasSubstr("has reached its limit"));
                       }});
  const auto a = recording.Open("/a", v1::FeltState());
  for (int i = 0; i < 3000; ++i) {
    v1::FeltState state;
    for (int k = 0; k < 20; ++k) state.add_stiffness(std::sin(i * 100.0 + k));
    recording.Put(a, Clock::now(), state);
  }
  recording.Finish();
  EXPECT_EQ(told, 1);
  EXPECT_LE(recording.stats().bytes, 100'000U);
}

TEST_F(RecordingTest, ASchemaBringsEveryFileItRefersTo) {
  const McapSchema schema = SchemaOf(*v1::ForceTick::descriptor());
  EXPECT_EQ(schema.name, "palpate.v1.ForceTick");
  google::protobuf::FileDescriptorSet files;
  ASSERT_TRUE(files.ParseFromString(schema.data));
  std::vector<std::string> names;
  for (const auto& file : files.file()) names.push_back(file.name());
  EXPECT_THAT(names,
              ::testing::ElementsAre("google/protobuf/timestamp.proto", "palpate/v1/state.proto",
                                     "palpate/v1/recording.proto"));
}

TEST_F(RecordingTest, AMessageOfAnotherTypeIsRefusedByName) {
  {
    Recording recording({.file = file_});
    recording.Put(recording.Open("/a", v1::FeltState()), Clock::now(), v1::FeltState());
  }
  RecordingReader reader(file_);
  ASSERT_TRUE(reader.Next());
  v1::ForceTick tick;
  try {
    reader.Read(&tick);
    FAIL() << "it was read";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/a is of palpate.v1.FeltState: accepted is"));
  }
}

TEST(RecordLimitTest, IsASizeInPeoplesUnits) {
  EXPECT_EQ(ParseRecordLimit("8 GB"), 8'000'000'000U);
  EXPECT_EQ(ParseRecordLimit("1.5MB"), 1'500'000U);
  EXPECT_EQ(ParseRecordLimit("1e6"), 1'000'000U);
  for (const char* text : {"", "GB", "-1 GB", "1 XB", "nan", "10", "1e30 TB", "8 GB more"}) {
    EXPECT_THROW(ParseRecordLimit(text), std::invalid_argument) << text;
  }
}

// The layout is that of numpy.lib.format, version 1.0.
TEST(NpyFileTest, HasTheHeaderThatNumpyReads) {
  const auto file =
      std::filesystem::temp_directory_path() / ("npy-test." + std::to_string(getpid()) + ".npy");
  auto rows = NpyFile::Of<double>(file, 3);
  const double row[] = {1, 2, 3};
  for (int i = 0; i < 2; ++i) rows.Add(std::span<const double>(row));
  rows.Finish();
  const std::string bytes = ReadWholeFile(file, 1000, "a test's file");
  std::filesystem::remove(file);
  ASSERT_EQ(bytes.size(), 128 + 6 * sizeof(double));
  EXPECT_EQ(bytes.substr(0, 10), std::string("\x93NUMPY\x01\x00\x76\x00", 10));
  EXPECT_THAT(bytes, HasSubstr("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }"));
  EXPECT_EQ(bytes[127], '\n');
}

}  // namespace
}  // namespace palpate
