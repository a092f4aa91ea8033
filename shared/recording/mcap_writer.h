// Writes an MCAP file (mcap.dev/spec) that is readable up to its last flush even after a crash. It
// has chunks with CRC and message indexes; closing adds summary, statistics and footer. Debian has
// no MCAP library for C++.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "shared/recording/chunk_codec.h"
#include "shared/recording/mcap_bytes.h"

namespace palpate {

struct McapSchema {
  std::string name;      // `palpate.v1.SlaveState`
  std::string encoding;  // `protobuf`
  std::string data;      // a FileDescriptorSet
};

// McapWriter is not thread-safe. Times are nanoseconds since 1970.
class McapWriter {
 public:
  struct Options {
    std::string library;                // name of the writing program
    std::uint64_t limit = 0;            // of the file [bytes]; 0: none
    std::size_t chunk_bytes = 1 << 20;  // uncompressed size of a chunk
    std::uint64_t before = 0;  // size of earlier files, which count toward the limit [bytes]
  };

  // Overwrites the file. Throws std::runtime_error if it cannot write.
  McapWriter(std::filesystem::path file, const Options& options);
  ~McapWriter() { Close(); }
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  // Adds a topic. Equal schemas are written once.
  std::uint16_t AddChannel(std::string_view topic, const McapSchema& schema,
                           std::string_view message_encoding = "protobuf");
  void Write(std::uint16_t channel, std::uint64_t time, std::string_view data);
  // Attaches a file.
  void Attach(std::string_view name, std::string_view media_type, std::string_view data,
              std::uint64_t time);
  void Note(std::string_view name, const McapMap& values);
  // Writes all data to the file.
  void Flush();
  // Flushes, and returns whether another file fits within the limit.
  [[nodiscard]] bool LeavesRoom();
  // Flushes, writes the summary and closes the file.
  void Close();

  // Returns whether writing has ended: closed, at the limit, or failed.
  [[nodiscard]] bool ended() const { return file_descriptor_ < 0; }
  // Returns why it ended early, as text; empty: it did not.
  [[nodiscard]] const std::string& trouble() const { return trouble_; }
  [[nodiscard]] bool failed() const { return failed_; }         // a write failed
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }  // of the file
  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }

 private:
  struct Indexed {
    std::uint64_t time, offset;
  };
  struct Summary {  // its records so far
    std::string schemas, channels, chunk_indexes, attachment_indexes, metadata_indexes;
  };
  struct Span {
    std::uint64_t first = 0, last = 0;
    bool empty = true;
    void Add(std::uint64_t time);
  };

  void AddToChunk(McapRecord kind, std::string_view content);
  [[nodiscard]] bool IsWithinLimit(std::uint64_t more) const;
  // Returns whether `bytes` and the summary fit within the limit; otherwise reports it and closes.
  [[nodiscard]] bool MakeRoom(std::uint64_t bytes);
  // Writes all of `part` or nothing.
  bool PutBytes(std::string_view part);
  void WriteChunk();
  [[nodiscard]] std::string MessageIndexes(std::map<std::uint16_t, std::uint64_t>* offsets) const;
  void WriteSummary();
  [[nodiscard]] std::string Statistics() const;
  void Fail(const std::string& why);

  const std::filesystem::path file_;
  const Options options_;
  int file_descriptor_ = -1;
  bool closing_ = false, failed_ = false;
  std::uint64_t bytes_ = 0;
  std::string trouble_;

  std::string chunk_;  // records not yet written
  Span chunk_times_, times_;
  std::map<std::uint16_t, std::vector<Indexed>> chunk_index_;
  ChunkPacker packer_;

  Summary summary_;
  std::map<std::string, std::uint16_t> schema_ids_;   // by name
  std::map<std::uint16_t, std::uint64_t> counts_;     // messages per channel, in the file
  std::map<std::uint16_t, std::uint32_t> sequences_;  // given out per channel
  std::uint64_t messages_ = 0;
  std::uint32_t chunks_ = 0, attachments_ = 0, notes_ = 0;
};

}  // namespace palpate
