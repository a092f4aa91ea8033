// Reads a recording message by message. Parts are read as one recording.
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
  // `file`: a file, or the common name of parts. Throws InputError if unreadable or no MCAP file.
  explicit RecordingReader(const std::filesystem::path& file);

  // Moves to the next message; returns false if there is none.
  bool Next();
  [[nodiscard]] std::string_view topic() const { return channel_->topic; }
  [[nodiscard]] Time at() const;
  // Valid until the next message.
  [[nodiscard]] std::string_view bytes() const { return message_.data; }
  // Throws InputError if it is of another type, or damaged.
  void Read(google::protobuf::Message* message) const;

  // Skips messages before `at`, from now on.
  void SkipBefore(Time at);
  // Returns the reader of the current part, with its attachments and metadata so far.
  [[nodiscard]] const McapReader& mcap() const { return *reader_; }
  // Returns the unreadable parts so far, as text; empty: none.
  [[nodiscard]] const std::string& damage() const;

 private:
  // Opens the next part; false: there is none.
  bool OpenNext();
  // Returns whether the current part belongs to the earlier ones; otherwise reports it.
  bool Belongs();
  void Damage(const std::string& what);

  const std::vector<std::filesystem::path> parts_;
  const bool is_one_file_;  // `file` exists itself
  std::size_t part_ = 0;    // index of the current part
  std::unique_ptr<McapReader> reader_;
  bool is_new_ = true;  // no message of it was read yet
  std::string identity_, damage_;
  int number_ = 0;  // number of the part
  McapMessage message_;
  const McapChannel* channel_ = nullptr;
  Time skip_before_{};
};

}  // namespace palpate
