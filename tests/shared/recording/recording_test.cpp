#include "shared/recording/recording.h"

#include <atomic>
#include <cmath>
#include <fstream>
#include <map>
#include <numeric>
#include <random>
#include <stdexcept>
#include <thread>

#include <gmock/gmock.h>
#include <google/protobuf/descriptor.pb.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "palpate/v1/recording.pb.h"

#include "shared/recording/recording_reader.h"
#include "shared/text/text.h"
#include "tests/support/eventually.h"
#include "tests/support/scratch.h"
#include "tests/support/thrown.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

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
    const auto a = recording.Open("/a", v1::SlaveState()),
               b = recording.Open("/b", v1::SlaveState());
    const auto put = [&](std::uint16_t channel) {
      for (std::uint64_t i = 1; i <= kEach; ++i) {
        v1::SlaveState state;
        state.set_sequence(i);
        recording.Put(channel, FromNanoseconds(i), state);
      }
    };
    const std::jthread first(put, a), second(put, b);
  }
  RecordingReader reader(file_);
  std::map<std::string, std::uint64_t> newest;
  for (v1::SlaveState state; reader.Next();) {
    reader.Read(&state);
    EXPECT_EQ(state.sequence(), ++newest[std::string(reader.topic())]);
    EXPECT_EQ(Nanoseconds(reader.at()), state.sequence());
  }
  EXPECT_EQ(newest, (std::map<std::string, std::uint64_t>{{"/a", kEach}, {"/b", kEach}}));
  EXPECT_TRUE(reader.mcap().is_whole());
}

TEST_F(RecordingTest, ExpensiveMessagesAreMadeByAnotherThread) {
  std::atomic<bool> elsewhere{false};
  const auto here = std::this_thread::get_id();
  {
    Recording recording({.file = file_});
    const auto a = recording.Open("/a", v1::SlaveState());
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

// Memory is bounded, and a recording has no gaps: more than may wait ends it.
TEST_F(RecordingTest, MoreThanMayWaitEndsTheRecordingWithoutAGap) {
  Recording recording({.file = file_, .max_waiting = 1000});
  const auto a = recording.Open("/a", v1::SlaveState());
  v1::SlaveState state;
  state.set_sequence(1);
  recording.Put(a, Clock::now(), state);
  recording.Put(a, Clock::now(), 5000, [] { return std::string(); });
  state.set_sequence(3);
  recording.Put(a, Clock::now(), state);
  EXPECT_THAT(recording.stats().trouble, HasSubstr("the recording has ended: the disk or the"));
  EXPECT_TRUE(recording.stats().failed);
  EXPECT_FALSE(recording.stats().falls_behind);
  recording.Finish();
  RecordingReader reader(file_);
  ASSERT_TRUE(reader.Next()) << "what waited is written";
  EXPECT_FALSE(reader.Next());
  EXPECT_TRUE(reader.mcap().is_whole());
}

TEST_F(RecordingTest, AnErrorOfAMessageEndsTheRecordingWithItsReason) {
  std::vector<std::string> reasons;
  Recording recording(
      {.file = file_, .tell = [&](const std::string& why) { reasons.push_back(why); }});
  const auto a = recording.Open("/a", v1::SlaveState());
  recording.Put(a, Clock::now(), v1::SlaveState());
  recording.Put(a, Clock::now(), 10,
                []() -> std::string { throw std::runtime_error("no such image"); });
  recording.Put(a, Clock::now(), v1::SlaveState());
  recording.Finish();
  EXPECT_THAT(recording.stats().trouble, HasSubstr("the recording has ended: no such image"));
  EXPECT_TRUE(recording.stats().failed);
  EXPECT_THAT(reasons, ::testing::ElementsAre(recording.stats().trouble));
  RecordingReader reader(file_);
  ASSERT_TRUE(reader.Next());
  EXPECT_FALSE(reader.Next());
  EXPECT_TRUE(reader.mcap().is_whole());
}

TEST_F(RecordingTest, OneThatFallsBehindIsReportedUntilItHasCaughtUp) {
  std::atomic<bool> released{false};
  Recording recording({.file = file_});
  const auto a = recording.Open("/a", v1::SlaveState());
  recording.Put(a, Clock::now(), 10, [&] {
    while (!released) std::this_thread::yield();
    return std::string();
  });
  EXPECT_TRUE(Eventually([&] { return recording.stats().falls_behind; }));
  EXPECT_THAT(recording.stats().trouble, HasSubstr("the recording falls behind: the last "));
  released = true;
  EXPECT_TRUE(Eventually([&] { return recording.stats().trouble.empty(); }));
  EXPECT_FALSE(recording.stats().falls_behind);
}

// The writer takes all of these from the queue at once.
TEST_F(RecordingTest, FinishedMessagesAreInTheFileWhileOthersAreMade) {
  std::atomic<bool> last_began{false}, released{false};
  Recording recording({.file = file_});
  const auto a = recording.Open("/a", v1::SlaveState());
  recording.Put(a, Clock::now(), v1::SlaveState());
  recording.Put(a, Clock::now(), 10, [] {
    std::this_thread::sleep_for(Seconds(1.1 * Recording::kFlushEvery));
    return std::string();
  });
  recording.Put(a, Clock::now(), 10, [&] {
    last_began = true;
    while (!released) std::this_thread::yield();
    return std::string();
  });
  EXPECT_TRUE(Eventually([&] { return last_began.load(); }));
  RecordingReader reader(file_);
  EXPECT_TRUE(reader.Next());
  released = true;
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
    recording.Put(recording.Open("/a", v1::SlaveState()), Clock::now(), v1::SlaveState());
  }
  RecordingReader reader(file_);
  ASSERT_TRUE(reader.Next());
  v1::ForceTick tick;
  EXPECT_THAT(Thrown<InputError>([&] { reader.Read(&tick); }),
              HasSubstr("/a is of palpate.v1.SlaveState: expected"));
}

class PartsTest : public FolderTest {
 protected:
  // Puts messages with numbers from 1 until part `parts` has begun. Returns their count.
  static std::uint64_t PutUntil(Recording* recording, std::uint16_t channel, int parts) {
    std::uint64_t count = 0;
    while (recording->part() < parts) {
      v1::SlaveState state;
      state.set_sequence(++count);
      recording->Put(channel, FromNanoseconds(count), state);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return count;
  }
  std::uint64_t Write(int parts) {
    Recording recording({.file = file_, .part = 0.02});
    recording.Attach("scene.yaml", "name: block");
    recording.Note("made", {{"by", "us"}});
    return PutUntil(&recording, recording.Open("/a", v1::SlaveState()), parts);
  }
  static std::vector<std::uint64_t> Samples(RecordingReader* reader) {
    std::vector<std::uint64_t> samples;
    for (v1::SlaveState state; reader->Next(); samples.push_back(state.sequence())) {
      reader->Read(&state);
    }
    return samples;
  }

  const std::filesystem::path file_ = folder_ / "a.mcap";
};

TEST_F(PartsTest, AreReadAsOneAndEachByItself) {
  std::vector<std::uint64_t> written(Write(3));
  std::iota(written.begin(), written.end(), 1);
  RecordingReader reader(file_);
  EXPECT_EQ(Samples(&reader), written);
  EXPECT_THAT(reader.damage(), IsEmpty());
  std::vector<std::uint64_t> apart;
  for (const char* name : {"a-0001.mcap", "a-0002.mcap", "a-0003.mcap"}) {
    RecordingReader part(folder_ / name);
    const auto samples = Samples(&part);
    EXPECT_FALSE(samples.empty()) << name;
    apart.insert(apart.end(), samples.begin(), samples.end());
    EXPECT_TRUE(part.mcap().is_whole()) << name;
    ASSERT_EQ(part.mcap().attachments().size(), 1U) << name;
    EXPECT_EQ(part.mcap().attachments()[0].data, "name: block");
    EXPECT_EQ(part.mcap().notes().at("made").at("by"), "us");
  }
  EXPECT_EQ(apart, written);
}

TEST_F(PartsTest, TimesBeforeAPlaceArePassedOverInAllOfThem) {
  const std::uint64_t last = Write(3);
  RecordingReader reader(file_);
  reader.SkipBefore(FromNanoseconds(last));
  EXPECT_EQ(Samples(&reader), std::vector{last});
  EXPECT_THAT(reader.damage(), IsEmpty());
}

TEST_F(PartsTest, AnEarlierRecordingStaysAndTheNextNumberIsWritten) {
  const auto make = [this](double part) {
    Recording recording({.file = file_, .part = part});
    recording.Put(recording.Open("/a", v1::SlaveState()), Clock::now(), v1::SlaveState());
    return recording.file().filename().string();
  };
  EXPECT_EQ(make(0), "a.mcap");
  const std::string first = Scratch::Read(file_);
  EXPECT_EQ(make(0), "a-2.mcap");
  EXPECT_EQ(make(1000), "a-3.mcap");
  EXPECT_EQ(make(0), "a-4.mcap") << "there are parts of a-3.mcap";
  EXPECT_EQ(Scratch::Read(file_), first);
  EXPECT_EQ(PartsOf(folder_ / "a-3.mcap"), std::vector{folder_ / "a-3-0001.mcap"});
  std::filesystem::remove(file_);
  EXPECT_EQ(PartsOf(file_), std::vector{file_}) << "the others are no parts of it";
}

TEST_F(PartsTest, OneThatIsLeftOfAnEarlierRecordingIsLeftOut) {
  Write(3);
  const std::uint64_t newer = Write(2);
  for (const char* number : {"0001", "0002"}) {
    std::filesystem::rename(folder_ / (std::string("a-2-") + number + ".mcap"),
                            folder_ / (std::string("a-") + number + ".mcap"));
  }
  RecordingReader reader(file_);
  EXPECT_EQ(Samples(&reader).size(), newer);
  EXPECT_THAT(reader.damage(), HasSubstr("a-0003.mcap: is not a part of this recording"));
}

TEST_F(PartsTest, OneCutAtItsBeginningEndsTheRecordingAsAKillDoes) {
  Write(3);
  for (const std::uintmax_t size : {0, 8, 30}) {
    std::filesystem::resize_file(folder_ / "a-0003.mcap", size);
    RecordingReader reader(file_);
    EXPECT_GT(Samples(&reader).size(), 2U);
    EXPECT_THAT(reader.damage(), HasSubstr("a-0003.mcap: ")) << size;
    EXPECT_THAT(reader.damage(), Not(HasSubstr("not a part of"))) << size;
  }
}

TEST_F(PartsTest, TheLimitHoldsForAllOfThem) {
  constexpr std::uint64_t kLimit = 100'000;
  Recording recording({.file = file_, .limit = kLimit, .part = 0.02});
  const auto a = recording.Open("/a", v1::SlaveState());
  std::mt19937 random(1);
  while (recording.stats().trouble.empty()) {
    std::string noise(1000, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    recording.Put(a, Clock::now(), noise.size(), [noise] { return noise; });
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_THAT(recording.stats().trouble, HasSubstr("has reached its limit of 100 kB"));
  std::uint64_t bytes = 0;
  for (const auto& file : std::filesystem::directory_iterator(folder_)) bytes += file.file_size();
  EXPECT_LE(bytes, kLimit);
  EXPECT_EQ(bytes, recording.stats().bytes);
  EXPECT_GT(recording.stats().parts, 1);
}

}  // namespace
}  // namespace palpate
