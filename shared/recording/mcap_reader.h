// Reads an MCAP file from its beginning as far as possible. It does not use the summary, so that a
// file of a killed writer is readable. Its memory is bounded by the file size and one uncompressed
// chunk.
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
  std::string topic;
  std::uint16_t schema = 0;
};

struct McapMessage {
  std::uint16_t channel = 0;
  std::uint64_t time = 0;  // time of recording since 1970 [ns]
  std::string_view data;   // valid until the next read
};

struct McapAttachment {
  std::string name, data;
};

class McapReader {
 public:
  static constexpr std::uint64_t kMaxChunk = 256 << 20;  // uncompressed; also for attachments

  // Throws InputError if the file is unreadable or no MCAP file.
  explicit McapReader(const std::filesystem::path& file);

  // Reads the next message, in the order of the file. False: there is none. Messages of unknown
  // channels are skipped.
  bool Next(McapMessage* message);
  // Skips chunks that end before `time`, from now on.
  void SkipBefore(std::uint64_t time) { skip_before_ = time; }

  // Returns the channels and schemas read so far. Null: unknown.
  [[nodiscard]] const McapChannel* channel(std::uint16_t id) const;
  [[nodiscard]] const McapSchema* schema(std::uint16_t id) const;
  [[nodiscard]] const std::vector<McapAttachment>& attachments() const { return attachments_; }
  [[nodiscard]] const std::map<std::string, McapMap>& notes() const { return notes_; }
  [[nodiscard]] const std::string& library() const { return library_; }

  // Returns whether the end of the data was reached; false: the file is truncated.
  [[nodiscard]] bool is_whole() const { return is_whole_; }
  // Returns the unreadable parts so far, as text; empty: none.
  [[nodiscard]] const std::string& damage() const { return damage_; }

 private:
  struct Head {
    McapRecord kind;
    std::uint64_t size;
  };
  // Reads the head of the next record. nullopt: end of the file, or truncated.
  std::optional<Head> ReadHead();
  bool ReadRecord();
  bool ReadBytes(std::uint64_t count, std::string* bytes);
  void Skip(std::uint64_t count);
  // Processes a record. True: it is a message, stored in `message`.
  bool TakeRecord(McapRecord kind, std::string_view content, McapMessage* message);
  void TakeSchema(std::string_view content);
  void TakeChannel(std::string_view content);
  void TakeChunk(std::string_view content);
  void TakeAttachment(std::string_view content);
  // Reports data that follows the end of the MCAP data.
  void LookBehind();
  void Damage(const std::string& what);

  const std::filesystem::path file_;
  std::ifstream stream_;
  std::uint64_t size_ = 0, at_ = 0;  // file size and read position [bytes]
  std::uint64_t record_at_ = 0;      // start of the last record
  std::uint64_t skip_before_ = 0;
  bool is_over_ = false, is_whole_ = false;
  std::string library_, damage_;
  std::string record_;     // newest record of the file
  McapRecord kind_{};      // kind of record_
  bool is_fresh_ = false;  // record_ was not taken yet
  std::string chunk_;      // newest chunk, unpacked
  std::string_view rest_;  // records of the chunk that are not read yet
  std::map<std::uint16_t, McapSchema> schemas_;
  std::map<std::uint16_t, McapChannel> channels_;
  std::vector<McapAttachment> attachments_;
  std::map<std::string, McapMap> notes_;
};

}  // namespace palpate
