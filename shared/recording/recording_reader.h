// A recording as programs read it: one message after the other, each by its topic.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include <google/protobuf/message.h>

#include "shared/recording/mcap_reader.h"
#include "shared/state/clock.h"

namespace palpate {

class RecordingReader {
 public:
  // Throws InputError: unreadable, not an MCAP file.
  explicit RecordingReader(const std::filesystem::path& file) : file_(file), reader_(file) {}

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
  // What is read so far tells of files, notes and damage.
  [[nodiscard]] const McapReader& mcap() const { return reader_; }

 private:
  const std::filesystem::path file_;
  McapReader reader_;
  McapMessage message_;
  const McapChannel* channel_ = nullptr;
  Time skip_before_{};
};

}  // namespace palpate
