// Writes a recording: messages enter a queue, and a thread of normal priority compresses and writes
// them, so that callers never wait for the disk. It makes one file, or parts by time, each of which
// is readable alone.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <google/protobuf/message.h>

#include "shared/link/priority_inheritance_mutex.h"
#include "shared/recording/mcap_bytes.h"
#include "shared/recording/mcap_writer.h"
#include "shared/state/clock.h"

namespace palpate {

// Parts of a recording: `session-0001.mcap`, `session-0002.mcap`, ... of `session.mcap`. Each is a
// recording by itself, and together they are one.
//
// Name of the metadata that identifies the recording of a part.
inline constexpr const char* kPartNote = "palpate.part";

// The file of part `number` (from 1) of the recording `file`. Names sort correctly up to 9999.
std::filesystem::path PartFile(const std::filesystem::path& file, int number);

// `identity`: common to all parts of a recording, and unique.
McapMap PartNote(const std::string& identity, int number);

// The files of the recording `file`, in order. Returns `file` itself if it exists or has no parts.
std::vector<std::filesystem::path> PartsOf(const std::filesystem::path& file);

// `file`, or the first of FILE-2, FILE-3, ... of which neither a file nor parts exist. Parts have
// four digits or more and these at most three, so that they are not confused. Throws
// std::runtime_error: all are taken.
std::filesystem::path UnusedFile(const std::filesystem::path& file);

inline std::uint64_t Nanoseconds(Time t) {
  return static_cast<std::uint64_t>(t.time_since_epoch().count());
}
inline Time FromNanoseconds(std::uint64_t ns) {
  return Time(Clock::duration(static_cast<Clock::rep>(ns)));
}

// Schema of a protobuf message with all its dependencies.
McapSchema SchemaOf(const google::protobuf::Descriptor& message);

// Thread-safe. Messages are written in order, without gaps: where too many wait, the recording
// ends.
class Recording {
 public:
  static constexpr std::uint64_t kDefaultLimit = 8'000'000'000;  // [bytes]
  static constexpr double kFlushEvery = 0.25;                    // [s]
  static constexpr double kMaxBehind = 1;  // age of unwritten messages without trouble [s]

  struct Options {
    std::filesystem::path file;           // the next unused one is written, see UnusedFile
    std::uint64_t limit = kDefaultLimit;  // of all parts
    std::string library;                  // recording program and version
    std::size_t max_waiting = 256 << 20;  // [bytes]; more ends the recording
    // Called on the writing thread, once each, with the reason that it ended or falls behind.
    std::function<void(const std::string&)> tell = nullptr;
    double part = 0;  // [s] after which a file ends and the next begins (PartFile); 0: one file
  };
  struct Stats {
    std::uint64_t bytes = 0, messages = 0;  // in all parts
    std::string trouble;                    // why it ended, or that it falls behind; empty: neither
    bool falls_behind = false;              // `trouble` is that it falls behind
    bool failed = false;                    // it ended before its limit
    int parts = 1;                          // parts so far
  };

  // Throws std::runtime_error if it cannot write.
  explicit Recording(Options options);
  ~Recording() { Finish(); }

  // Adds a channel before the first message. `example`: a message of its type.
  std::uint16_t Open(std::string_view topic, const google::protobuf::Message& example);
  // Add a file or metadata to each part, before the first message.
  void Attach(std::string_view name, std::string_view data);
  void Note(std::string_view name, const McapMap& values);

  void Put(std::uint16_t channel, Time at, const google::protobuf::Message& message);
  // `make` returns the bytes of the message and is called on the writing thread. `size`: their
  // estimate.
  void Put(std::uint16_t channel, Time at, std::size_t size, std::function<std::string()> make);
  // Puts a message that stays valid until the next one of the channel. Each part begins with it.
  void PutStanding(std::uint16_t channel, Time at, const google::protobuf::Message& message);
  // The file that is written, or the common name of its parts.
  [[nodiscard]] const std::filesystem::path& file() const { return options_.file; }
  // Returns the number of the part of the next message, from 1.
  [[nodiscard]] int part() const;
  // Writes all messages and closes the file.
  void Finish();
  [[nodiscard]] Stats stats() const;

 private:
  struct Waiting {
    std::uint16_t channel;
    Time at;
    std::size_t size;
    std::string bytes;
    std::function<std::string()> make;  // empty: `bytes`
    bool is_standing = false;
    int part = 1;
    Time queued_at{};
  };
  using Beginning = std::function<void(McapWriter*)>;
  void RunFirst(Beginning step);
  void PutWaiting(Waiting waiting);
  // Opens part `number` with the common beginning.
  [[nodiscard]] std::unique_ptr<McapWriter> BeginPart(int number) const;
  void GoOnIn(int part, Time at);
  void Run(const std::stop_token& stop);
  // Writes the batch. `is_last`: closes the file. An error ends the recording and nothing else.
  void WriteBatch(std::deque<Waiting>* batch, bool is_last);
  void Drain(std::deque<Waiting>* batch);
  // `batch`: the messages that were taken from the queue and are not yet written.
  void FlushWhenDue(const std::deque<Waiting>& batch);
  [[nodiscard]] std::string TextIfBehind() const;  // empty: it keeps up
  void CheckEnd();

  const Options options_;
  const std::string identity_;  // common to all parts
  // Used by the thread only, once it runs.
  std::vector<Beginning> beginning_;               // beginning of each part
  std::map<std::uint16_t, std::string> standing_;  // by channel, in each part
  int written_part_ = 1;
  std::uint64_t bytes_before_ = 0, messages_before_ = 0;  // in earlier parts
  std::string broken_;                                    // error outside of the writer
  Time flushed_at_ = Clock::now();
  bool is_lag_reported_ = false;
  std::unique_ptr<McapWriter> writer_;

  mutable PriorityInheritanceMutex mutex_;  // guards the members below
  PriorityInheritanceCondition changed_;    // never notified; it only ends a wait at a stop
  std::deque<Waiting> queue_;
  std::size_t waiting_ = 0;               // [bytes]
  std::optional<Time> oldest_unwritten_;  // when the oldest one was queued
  Stats stats_;
  Time part_began_ = Clock::now();
  bool is_closed_ = false, is_reported_ = false;  // closed; the reason was reported

  std::jthread thread_;  // last: it uses all of the above
};

// Parses a size: `500 MB`, `2GB`, `1e9` [bytes]. Throws std::invalid_argument: `--record-limit = x:
// expected ...`.
std::uint64_t ParseRecordLimit(std::string_view text);

}  // namespace palpate
