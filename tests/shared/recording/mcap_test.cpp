#include <algorithm>
#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include "shared/recording/mcap_reader.h"
#include "shared/recording/mcap_writer.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

struct LoggedMessage {
  std::string topic;
  std::uint64_t time = 0;
  std::string data;
  bool operator==(const LoggedMessage&) const = default;
};

class McapTest : public ::testing::Test {
 protected:
  McapTest() { std::filesystem::create_directories(folder_); }
  ~McapTest() override { std::filesystem::remove_all(folder_); }

  // Two topics, a file and a note; a chunk each eight messages.
  std::vector<LoggedMessage> WriteSmall(const std::filesystem::path& file) {
    McapWriter writer(file, {.library = "test"});
    writer.Attach("scene.yaml", "text/yaml", "name: block\n", 5);
    writer.Note("made", {{"by", "us"}, {"when", "now"}});
    const auto a = writer.AddChannel("/a", {"A", "protobuf", "schema of A"});
    const auto b = writer.AddChannel("/b", {"B", "protobuf", "schema of B"});
    std::vector<LoggedMessage> messages;
    for (std::uint64_t i = 0; i < 24; ++i) {
      messages.push_back({i % 3 == 0 ? "/b" : "/a", 1000 + 10 * i, std::string(i, 'x')});
      writer.Write(i % 3 == 0 ? b : a, messages.back().time, messages.back().data);
      if (i % 8 == 7) writer.Flush();
    }
    return messages;
  }
  static std::vector<LoggedMessage> ReadAll(McapReader* reader) {
    std::vector<LoggedMessage> messages;
    for (McapMessage message; reader->Next(&message);) {
      messages.push_back(
          {reader->channel(message.channel)->topic, message.time, std::string(message.data)});
    }
    return messages;
  }
  static void WriteBytes(const std::filesystem::path& file, std::string_view bytes) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
  }

  // In memory if the system has such a folder: a file is written thousands of times.
  static std::filesystem::path Base() {
    const std::filesystem::path memory = "/dev/shm";
    return exists(memory) ? memory : std::filesystem::temp_directory_path();
  }

  const std::filesystem::path folder_ = Base() / ("mcap-test." + std::to_string(getpid()));
  const std::filesystem::path file_ = folder_ / "a.mcap", other_ = folder_ / "b.mcap";
};

TEST_F(McapTest, WhatIsWrittenIsReadAgain) {
  const auto written = WriteSmall(file_);
  McapReader reader(file_);
  EXPECT_EQ(ReadAll(&reader), written);
  EXPECT_TRUE(reader.is_whole());
  EXPECT_THAT(reader.damage(), IsEmpty());
  EXPECT_EQ(reader.library(), "test");
  ASSERT_EQ(reader.attachments().size(), 1U);
  EXPECT_EQ(reader.attachments()[0].name, "scene.yaml");
  EXPECT_EQ(reader.attachments()[0].data, "name: block\n");
  EXPECT_EQ(reader.notes().at("made"), (McapMap{{"by", "us"}, {"when", "now"}}));
  EXPECT_EQ(reader.schema(1)->data, "schema of A");
}

TEST_F(McapTest, WhatFollowsItsEndIsReportedWithItsPlace) {
  const auto written = WriteSmall(file_);
  const std::string one = ReadWholeFile(file_, 1 << 20, "a recording");
  for (const auto& [more, words] : {std::pair{one, "another recording follows"},
                                    {std::string("tail"), "behind its end are 4 bytes"}}) {
    WriteBytes(other_, one + more);
    McapReader reader(other_);
    EXPECT_EQ(ReadAll(&reader), written);
    EXPECT_TRUE(reader.is_whole());
    EXPECT_THAT(reader.damage(), HasSubstr("at byte " + std::to_string(one.size()) + ": " + words));
  }
}

// After truncation at any byte, all data flushed before it can be read, and no data that was not
// written.
TEST_F(McapTest, AFileCutAtAnyByteKeepsTheDataFlushedBefore) {
  const auto written = WriteSmall(file_);
  const std::string bytes = ReadWholeFile(file_, 1 << 20, "a test's file");
  std::size_t kept = 0;
  for (std::size_t size = kMcapMagic.size(); size < bytes.size(); ++size) {
    WriteBytes(other_, std::string_view(bytes).substr(0, size));
    McapReader reader(other_);
    const auto read = ReadAll(&reader);
    ASSERT_LE(read.size(), written.size());
    ASSERT_TRUE(std::equal(read.begin(), read.end(), written.begin())) << "cut at " << size;
    ASSERT_GE(read.size(), kept) << "cut at " << size << ": less than with fewer bytes";
    ASSERT_EQ(read.size() % 8, 0U) << "cut at " << size << ": a chunk in part";
    kept = read.size();
  }
  EXPECT_EQ(kept, written.size());
}

// Checksums cover every part of a message.
TEST_F(McapTest, ADamagedByteNeverMakesAMessageThatWasNotWritten) {
  const auto written = WriteSmall(file_);
  const std::string bytes = ReadWholeFile(file_, 1 << 20, "a test's file");
  for (std::size_t i = kMcapMagic.size(); i < bytes.size(); ++i) {
    const char flip = std::array{'\x01', '\x80', '\xff'}[i % 3];
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ flip);
    WriteBytes(other_, damaged);
    McapReader reader(other_);
    for (const LoggedMessage& message : ReadAll(&reader)) {
      ASSERT_NE(std::ranges::find(written, message), written.end()) << "byte " << i;
    }
  }
}

TEST_F(McapTest, LengthsBeyondTheFileTakeNoMemory) {
  std::string bytes(kMcapMagic);
  McapPacker(&bytes).Add(static_cast<std::uint8_t>(McapRecord::kChunk)).Add(~std::uint64_t{0});
  WriteBytes(file_, bytes);
  McapReader reader(file_);
  EXPECT_THAT(ReadAll(&reader), IsEmpty());
  EXPECT_THAT(reader.damage(), HasSubstr("it is truncated"));
  EXPECT_FALSE(reader.is_whole());
}

TEST_F(McapTest, AChunkThatUnpacksToMoreThanTheLimitIsRefused) {
  std::string content, bytes(kMcapMagic);
  McapPacker(&content).Add(std::uint64_t{0}).Add(std::uint64_t{0}).Add(std::uint64_t{1} << 40);
  McapPacker(&content).Add(std::uint32_t{0}).Add(kZstd).AddBytes("x");
  McapPacker(&bytes).AddRecord(McapRecord::kChunk, content);
  WriteBytes(file_, bytes);
  McapReader reader(file_);
  EXPECT_THAT(ReadAll(&reader), IsEmpty());
  EXPECT_THAT(reader.damage(), HasSubstr("at byte 8"));
}

TEST_F(McapTest, ChunksThatEndBeforeATimeArePassedOver) {
  const auto written = WriteSmall(file_);
  McapReader reader(file_);
  McapMessage message;
  ASSERT_TRUE(reader.Next(&message));
  reader.SkipBefore(written[20].time);
  const auto rest = ReadAll(&reader);
  // The rest of the first chunk, and the last one.
  EXPECT_EQ(rest.size(), 15U);
  EXPECT_EQ(rest.back(), written.back());
}

TEST_F(McapTest, AReachedLimitEndsTheFileCompletelyAndIsReported) {
  constexpr std::uint64_t kLimit = 200'000;
  std::mt19937 random(1);
  McapWriter writer(file_, {.library = "test", .limit = kLimit, .chunk_bytes = 8192});
  const auto a = writer.AddChannel("/a", {"A", "protobuf", "schema"});
  for (std::uint64_t i = 0; i < 4000 && !writer.ended(); ++i) {
    std::string noise(100, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    writer.Write(a, i, noise);
  }
  EXPECT_TRUE(writer.ended());
  EXPECT_FALSE(writer.failed());
  EXPECT_THAT(writer.trouble(), HasSubstr("has reached its limit of 200 kB"));
  EXPECT_LE(std::filesystem::file_size(file_), kLimit);
  EXPECT_GT(std::filesystem::file_size(file_), kLimit * 9 / 10);
  McapReader reader(file_);
  EXPECT_EQ(ReadAll(&reader).size(), writer.messages());
  EXPECT_TRUE(reader.is_whole());
}

TEST_F(McapTest, OnAFullDiskTheFileStaysReadableAndTheErrorIsReported) {
  EXPECT_THROW(McapWriter("/dev/full", {}), std::runtime_error);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  McapWriter writer(file_, {.library = "test", .chunk_bytes = 4096});
  const auto a = writer.AddChannel("/a", {"A", "protobuf", "schema"});
  const rlimit full{50'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  std::mt19937 random(1);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    std::string noise(100, '\0');
    for (char& c : noise) c = static_cast<char>(random());
    writer.Write(a, i, noise);
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_TRUE(writer.failed());
  EXPECT_THAT(writer.trouble(), HasSubstr("cannot be written: "));
  McapReader reader(file_);
  const auto read = ReadAll(&reader);
  EXPECT_GT(read.size(), 300U);
  EXPECT_EQ(read.size(), writer.messages());
}

}  // namespace
}  // namespace palpate
