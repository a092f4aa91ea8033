// A recording as programs read it: one message after the other, each by its topic. One in parts is
// read as one.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/message.h>

#include "shared/recording/mcap_reader.h"
#include "shared/state/clock.h"

namespace palpate {

class RecordingReader {
 public:
  // A file, or the name whose parts there are. Throws InputError: unreadable, not an MCAP file.
  explicit RecordingReader(const std::filesystem::path& file);

  // Goes to the next message; false: there is no more.
  bool Next();
  [[nodiscard]] std::string_view topic() const { return channel_->topic; }
  [[nodiscard]] Time at() const;
  // Until the next one.
  [[nodiscard]] std::string_view bytes() const { return message_.data; }
  // Throws InputError: it is of another type, or damaged.
  void Read(google::protobuf::Message* message) const;

  // Messages before `at` are passed over from here on.
  void SkipBefore(Time at);
  // Of the part that is read: what was read of it tells of files and notes.
  [[nodiscard]] const McapReader& mcap() const { return *reader_; }
  // What could not be read so far, in words; empty: nothing.
  [[nodiscard]] const std::string& damage() const;

 private:
  // The next part; false: there is none that belongs to it.
  bool OpenNext();
  // Whether the part, of which a message was read, belongs to those before it; else says so.
  bool Belongs();
  void Damage(const std::string& what);

  const std::vector<std::filesystem::path> parts_;
  const bool is_one_file_;  // that was named itself
  std::size_t part_ = 0;    // which of them is read
  std::unique_ptr<McapReader> reader_;
  bool is_new_ = true;  // nothing was read of it
  std::string identity_, damage_;
  int number_ = 0;  // of the part
  McapMessage message_;
  const McapChannel* channel_ = nullptr;
  Time skip_before_{};
};

}  // namespace palpate
