// Reads an MCAP file from its beginning, as far as it goes: the summary is not asked, so that a
// file whose writer was killed reads like any other. Whatever the file says, it takes no more
// memory than the file has bytes and one chunk unpacks to.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/recording/mcap_bytes.h"
#include "shared/recording/mcap_writer.h"

namespace palpate {

struct McapChannel {
  std::string topic, message_encoding;
  std::uint16_t schema = 0;
};

struct McapMessage {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t time = 0;  // [ns] since 1970, when it was recorded
  std::string_view data;   // until the next one is read
};

struct McapAttachment {
  std::string name, media_type, data;
};

class McapReader {
 public:
  static constexpr std::uint64_t kLargestChunk = 256 << 20;  // unpacked, as of an attachment

  // Throws InputError: unreadable, not an MCAP file.
  explicit McapReader(const std::filesystem::path& file);

  // The next message, in the file's order. False: there is no more. Messages of channels that the
  // file does not tell of are passed over.
  bool Next(McapMessage* message);
  // Chunks that end before `time` are passed over unread from here on, but for the channels and
  // schemas of those already read.
  void SkipBefore(std::uint64_t time) { skip_before_ = time; }

  // As told so far. Null: the file tells of none.
  [[nodiscard]] const McapChannel* channel(std::uint16_t id) const;
  [[nodiscard]] const McapSchema* schema(std::uint16_t id) const;
  [[nodiscard]] const std::vector<McapAttachment>& attachments() const { return attachments_; }
  [[nodiscard]] const std::map<std::string, McapMap>& notes() const { return notes_; }
  [[nodiscard]] const std::string& library() const { return library_; }

  // The end of the data was reached; false: the file is cut.
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  // What could not be read, in words, once it was reached; empty: nothing.
  [[nodiscard]] const std::string& damage() const { return damage_; }

 private:
  struct Head {
    McapRecord kind;
    std::uint64_t size;
  };
  // Of the next record in the file. nullopt: the file ends, or is cut.
  std::optional<Head> ReadHead();
  bool ReadRecord();
  bool ReadBytes(std::uint64_t count, std::string* bytes);
  void Skip(std::uint64_t count);
  // True: a message, which is in `message`.
  bool Take(McapRecord kind, std::string_view content, McapMessage* message);
  void TakeSchema(std::string_view content);
  void TakeChannel(std::string_view content);
  void TakeChunk(std::string_view content);
  void TakeAttachment(std::string_view content);
  void Damage(const std::string& what);

  const std::filesystem::path file_;
  std::ifstream stream_;
  std::uint64_t size_ = 0, at_ = 0;  // of the file; what was read of it [bytes]
  std::uint64_t record_at_ = 0;      // where the last record begins
  std::uint64_t skip_before_ = 0;
  bool is_over_ = false, is_whole_ = false;
  std::string library_, damage_;
  std::string record_;     // of the file
  McapRecord kind_{};      // of it
  bool is_fresh_ = false;  // it was not taken yet
  std::string chunk_;      // unpacked
  std::string_view rest_;  // of it
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::vector<McapAttachment> attachments_;
  std::map<std::string, McapMap> notes_;
};

}  // namespace palpate
