#include "shared/recording/mcap_writer.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::uint64_t kFooterRoom = 2048;  // footer, statistics, offsets
constexpr std::uint64_t kHeaderRoom = 1024;

std::string Record(McapRecord kind, std::string_view content) {
  std::string record;
  McapPacker(&record).AddRecord(kind, content);
  return record;
}

std::string InWords(std::uint64_t bytes) {
  constexpr double kStep = 1000;
  double size = static_cast<double>(bytes) / kStep;
  const char* unit = "kB";
  for (const char* larger : {"MB", "GB", "TB"}) {
    if (size < kStep) break;
    size /= kStep;
    unit = larger;
  }
  return Formatted("%.4g %s", size, unit);
}

}  // namespace

void McapWriter::Span::Add(std::uint64_t time) {
  first = empty ? time : std::min(first, time);
  last = empty ? time : std::max(last, time);
  empty = false;
}

McapWriter::McapWriter(std::filesystem::path file, const Options& options)
    : file_(std::move(file)), options_(options) {
  constexpr mode_t kMode = 0644;
  file_descriptor_ = open(file_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, kMode);
  if (file_descriptor_ < 0) {
    throw std::runtime_error(file_.string() + ": cannot be written: " + std::strerror(errno));
  }
  std::string header;
  McapPacker(&header).Add(std::string_view()).Add(options.library);
  PutBytes(std::string(kMcapMagic) + Record(McapRecord::kHeader, header));
  if (!trouble_.empty()) throw std::runtime_error(trouble_);
}

std::uint16_t McapWriter::AddChannel(std::string_view topic, const McapSchema& schema,
                                     std::string_view message_encoding) {
  auto [known, is_new] =
      schema_ids_.try_emplace(schema.name, static_cast<std::uint16_t>(schema_ids_.size() + 1));
  if (is_new) {
    std::string content;
    McapPacker(&content).Add(known->second).Add(schema.name).Add(schema.encoding).Add(schema.data);
    AddToChunk(McapRecord::kSchema, content);
    summary_.schemas += Record(McapRecord::kSchema, content);
  }
  const auto id = static_cast<std::uint16_t>(counts_.size() + 1);
  counts_[id] = 0;
  std::string content;
  McapPacker(&content).Add(id).Add(known->second).Add(topic).Add(message_encoding).Add(McapMap{});
  AddToChunk(McapRecord::kChannel, content);
  summary_.channels += Record(McapRecord::kChannel, content);
  return id;
}

void McapWriter::AddToChunk(McapRecord kind, std::string_view content) {
  if (!ended()) McapPacker(&chunk_).AddRecord(kind, content);
}

void McapWriter::Write(std::uint16_t channel, std::uint64_t time, std::string_view data) {
  if (ended()) return;
  chunk_index_[channel].push_back({time, chunk_.size()});
  chunk_times_.Add(time);
  std::string head;
  McapPacker(&head).Add(channel).Add(++sequences_[channel]);
  McapPacker(&head).Add(time).Add(time);
  McapPacker(&chunk_)
      .Add(static_cast<std::uint8_t>(McapRecord::kMessage))
      .Add(static_cast<std::uint64_t>(head.size() + data.size()));
  chunk_.append(head).append(data);
  if (chunk_.size() >= options_.chunk_bytes) WriteChunk();
}

void McapWriter::Attach(std::string_view name, std::string_view media_type, std::string_view data,
                        std::uint64_t time) {
  Flush();
  std::string content;
  McapPacker(&content).Add(time).Add(std::uint64_t{0}).Add(name).Add(media_type).AddBytes(data);
  McapPacker(&content).Add(Crc32(content));
  const std::uint64_t at = bytes_;
  if (!MakeRoom(content.size() + kMcapRecordHead)) return;
  if (!PutBytes(Record(McapRecord::kAttachment, content))) return;
  ++attachments_;
  std::string index;
  McapPacker(&index).Add(at).Add(bytes_ - at).Add(time).Add(std::uint64_t{0});
  McapPacker(&index).Add(static_cast<std::uint64_t>(data.size())).Add(name).Add(media_type);
  summary_.attachment_indexes += Record(McapRecord::kAttachmentIndex, index);
}

void McapWriter::Note(std::string_view name, const McapMap& values) {
  Flush();
  std::string content;
  McapPacker(&content).Add(name).Add(values);
  const std::uint64_t at = bytes_;
  if (!MakeRoom(content.size() + kMcapRecordHead)) return;
  if (!PutBytes(Record(McapRecord::kMetadata, content))) return;
  ++notes_;
  std::string index;
  McapPacker(&index).Add(at).Add(bytes_ - at).Add(name);
  summary_.metadata_indexes += Record(McapRecord::kMetadataIndex, index);
}

void McapWriter::Flush() {
  if (!chunk_.empty()) WriteChunk();
}

bool McapWriter::IsWithinLimit(std::uint64_t more) const {
  const std::uint64_t summary = summary_.schemas.size() + summary_.channels.size() +
                                summary_.chunk_indexes.size() + summary_.attachment_indexes.size() +
                                summary_.metadata_indexes.size() + kFooterRoom;
  return options_.limit == 0 || options_.before + bytes_ + more + summary <= options_.limit;
}

bool McapWriter::LeavesRoom() {
  Flush();
  // Schemas and channels are written where their messages begin and again at the end.
  const std::uint64_t entries = 2 * (summary_.schemas.size() + summary_.channels.size());
  return IsWithinLimit(kHeaderRoom + entries + kFooterRoom);
}

bool McapWriter::MakeRoom(std::uint64_t bytes) {
  if (ended()) return false;
  if (IsWithinLimit(bytes)) return true;
  if (trouble_.empty()) {
    trouble_ = file_.string() + ": the recording has ended: it has reached its limit of " +
               InWords(options_.limit);
  }
  chunk_.clear();
  Close();
  return false;
}

bool McapWriter::PutBytes(std::string_view part) {
  const std::uint64_t before = bytes_;
  while (!part.empty()) {
    const ssize_t written = write(file_descriptor_, part.data(), part.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      const int error = errno;
      bytes_ = before;
      // Removes an incomplete record, because readers stop there.
      if (ftruncate(file_descriptor_, static_cast<off_t>(before)) == 0) {
        lseek(file_descriptor_, static_cast<off_t>(before), SEEK_SET);
      }
      Fail(std::strerror(error));
      return false;
    }
    bytes_ += static_cast<std::uint64_t>(written);
    part.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::string McapWriter::MessageIndexes(std::map<std::uint16_t, std::uint64_t>* offsets) const {
  std::string indexes;
  for (const auto& [channel, messages] : chunk_index_) {
    (*offsets)[channel] = indexes.size();
    std::string entries, content;
    for (const Indexed& message : messages) {
      McapPacker(&entries).Add(message.time).Add(message.offset);
    }
    McapPacker(&content).Add(channel).Add(std::string_view(entries));
    McapPacker(&indexes).AddRecord(McapRecord::kMessageIndex, content);
  }
  return indexes;
}

void McapWriter::WriteChunk() {
  std::string packed, content;
  if (!packer_.Pack(chunk_, &packed)) return Fail("no memory to pack it");
  const auto size = static_cast<std::uint64_t>(chunk_.size());
  McapPacker(&content).Add(chunk_times_.first).Add(chunk_times_.last).Add(size);
  McapPacker(&content).Add(Crc32(chunk_)).Add(kZstd).AddBytes(packed);
  std::map<std::uint16_t, std::uint64_t> offsets;
  std::string part = Record(McapRecord::kChunk, content);
  const std::uint64_t at = bytes_, length = part.size();
  part += MessageIndexes(&offsets);
  if (!MakeRoom(part.size()) || !PutBytes(part)) return;

  std::string where, index;
  for (const auto& [channel, offset] : offsets) {
    McapPacker(&where).Add(channel).Add(at + length + offset);
  }
  McapPacker(&index).Add(chunk_times_.first).Add(chunk_times_.last).Add(at).Add(length);
  McapPacker(&index).Add(std::string_view(where)).Add(bytes_ - at - length).Add(kZstd);
  McapPacker(&index).Add(static_cast<std::uint64_t>(packed.size())).Add(size);
  McapPacker(&summary_.chunk_indexes).AddRecord(McapRecord::kChunkIndex, index);
  ++chunks_;
  for (const auto& [channel, messages] : chunk_index_) {
    counts_[channel] += messages.size();
    messages_ += messages.size();
  }
  if (!chunk_times_.empty) {
    times_.Add(chunk_times_.first);
    times_.Add(chunk_times_.last);
  }
  chunk_.clear();
  chunk_index_.clear();
  chunk_times_ = {};
}

std::string McapWriter::Statistics() const {
  std::string content, counts;
  for (const auto& [channel, count] : counts_) McapPacker(&counts).Add(channel).Add(count);
  McapPacker(&content).Add(messages_).Add(static_cast<std::uint16_t>(schema_ids_.size()));
  McapPacker(&content).Add(static_cast<std::uint32_t>(counts_.size()));
  McapPacker(&content).Add(attachments_).Add(notes_).Add(chunks_).Add(times_.first);
  McapPacker(&content).Add(times_.last).Add(std::string_view(counts));
  return Record(McapRecord::kStatistics, content);
}

// Writes groups of records of the same type, the offset of each group, and the offset of the
// summary.
void McapWriter::WriteSummary() {
  std::string part, offsets;
  McapPacker(&part).AddRecord(McapRecord::kDataEnd, std::string(sizeof(std::uint32_t), '\0'));
  const std::uint64_t begin = bytes_ + part.size();
  std::string summary;
  const auto add = [&](McapRecord kind, const std::string& group) {
    if (group.empty()) return;
    std::string content;
    McapPacker(&content).Add(static_cast<std::uint8_t>(kind)).Add(begin + summary.size());
    McapPacker(&content).Add(static_cast<std::uint64_t>(group.size()));
    McapPacker(&offsets).AddRecord(McapRecord::kSummaryOffset, content);
    summary += group;
  };
  add(McapRecord::kSchema, summary_.schemas);
  add(McapRecord::kChannel, summary_.channels);
  add(McapRecord::kStatistics, Statistics());
  add(McapRecord::kChunkIndex, summary_.chunk_indexes);
  add(McapRecord::kAttachmentIndex, summary_.attachment_indexes);
  add(McapRecord::kMetadataIndex, summary_.metadata_indexes);
  const std::uint64_t offsets_at = begin + summary.size();
  summary += offsets;
  constexpr std::uint64_t kFooterSize = 20;
  McapPacker(&summary).Add(static_cast<std::uint8_t>(McapRecord::kFooter)).Add(kFooterSize);
  McapPacker(&summary).Add(begin).Add(offsets_at);
  McapPacker(&summary).Add(Crc32(summary));
  PutBytes(part + summary + std::string(kMcapMagic));
}

void McapWriter::Fail(const std::string& why) {
  failed_ = true;
  if (trouble_.empty()) {
    trouble_ = file_.string() + ": the recording has ended: it cannot be written: " + why;
  }
  chunk_.clear();
  Close();
}

void McapWriter::Close() {
  if (ended() || std::exchange(closing_, true)) return;
  Flush();
  WriteSummary();
  close(std::exchange(file_descriptor_, -1));
}

}  // namespace palpate
