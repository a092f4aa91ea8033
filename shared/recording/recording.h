// A recording as programs make it: messages go into a queue, and a thread of normal priority packs
// and writes them. Whoever records never waits for a disk. One file, or parts by time, each of
// which begins with all that the messages in it need to be read.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <google/protobuf/message.h>

#include "shared/recording/mcap_writer.h"
#include "shared/state/clock.h"

namespace palpate {

inline std::uint64_t Nanoseconds(Time t) {
  return static_cast<std::uint64_t>(t.time_since_epoch().count());
}
inline Time FromNanoseconds(std::uint64_t ns) {
  return Time(Clock::duration(static_cast<Clock::rep>(ns)));
}

// What a protobuf message is, with all that it refers to.
McapSchema SchemaOf(const google::protobuf::Descriptor& message);

// Thread-safe; what was put in first is written first.
class Recording {
 public:
  static constexpr std::uint64_t kDefaultLimit = 8'000'000'000;  // [bytes]
  static constexpr double kFlushEvery = 0.25;                    // [s]

  struct Options {
    std::filesystem::path file;
    std::uint64_t limit = kDefaultLimit;   // of all parts
    std::string library;                   // who records: program and version
    std::size_t most_waiting = 256 << 20;  // [bytes]
    // That it ended, or loses what comes: once each, in words, by the writing thread.
    std::function<void(const std::string&)> tell = nullptr;
    double part = 0;  // [s] after which a file ends and the next begins (PartFile); 0: one file
  };
  struct Stats {
    std::uint64_t bytes = 0, messages = 0;  // in all parts
    std::uint64_t dropped = 0;              // because the disk was slower than what came
    std::string trouble;                    // why it ended or is not whole; empty: neither
    bool failed = false;                    // it could not be written
    int parts = 1;                          // begun
  };

  // Throws std::runtime_error: it cannot be written, or would be hidden by a file of its name.
  explicit Recording(Options options);
  ~Recording() { Finish(); }

  // Before anything is put in. `example`: of what comes there.
  std::uint16_t Open(std::string_view topic, const google::protobuf::Message& example);
  // Before anything is put in: a file that belongs to it; what is to be known of it. In each part.
  void Attach(std::string_view name, std::string_view data);
  void Note(std::string_view name, const McapMap& values);

  void Put(std::uint16_t channel, Time at, const google::protobuf::Message& message);
  // `make` is asked for the message's bytes by the writing thread; `size`: about as many.
  void Put(std::uint16_t channel, Time at, std::size_t size, std::function<std::string()> make);
  // Of a channel whose newest message holds until the next one: each part begins with it.
  void PutStanding(std::uint16_t channel, Time at, const google::protobuf::Message& message);
  // Of what is put in next: from 1, rising.
  [[nodiscard]] int part() const;
  // Everything put in is written, the file closed.
  void Finish();
  [[nodiscard]] Stats stats() const;

 private:
  struct Waiting {
    std::uint16_t channel;
    Time at;
    std::size_t size;
    std::string bytes;
    std::function<std::string()> make;  // empty: `bytes`
    bool stands = false;
    int part = 1;
  };
  using Beginning = std::function<void(McapWriter*)>;
  void Begin(Beginning step);
  void Put(Waiting waiting);
  // Of this number, with what each part begins with.
  [[nodiscard]] std::unique_ptr<McapWriter> BeginPart(int number) const;
  void GoOnIn(int part, Time at);
  void Run(const std::stop_token& stop);
  void Drain(std::deque<Waiting>* batch);
  void CheckLoss();
  void CheckEnd();

  const Options options_;
  const std::string identity_;  // which all parts have in common
  // The thread's own once it runs.
  std::vector<Beginning> beginning_;               // of each part
  std::map<std::uint16_t, std::string> standing_;  // by channel, likewise
  int written_part_ = 1;
  std::uint64_t bytes_before_ = 0, messages_before_ = 0;  // in parts before it
  std::string broken_;                                    // why the next part could not begin
  std::unique_ptr<McapWriter> writer_;

  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  std::deque<Waiting> queue_;
  std::size_t waiting_ = 0;  // [bytes]
  Stats stats_;
  Time part_began_ = Clock::now();
  bool is_closed_ = false, is_told_ = false;  // nothing more is taken; why was told
  bool is_loss_told_ = false;

  std::jthread thread_;  // last: it uses all of the above
};

// A number of bytes as people write it: `500 MB`, `2GB`, `1e9`. Throws std::invalid_argument:
// `--record-limit = x: accepted is ...`.
std::uint64_t ParseRecordLimit(std::string_view text);

}  // namespace palpate
