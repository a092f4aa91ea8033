#include "shared/recording/mcap_reader.h"

#include <algorithm>
#include <utility>

#include "shared/recording/chunk_codec.h"
#include "shared/text/file_format.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::uint64_t kChunkHead = 32;  // bytes of a chunk before the name of its compression

}  // namespace

McapReader::McapReader(const std::filesystem::path& file)
    : file_(file), stream_(file, std::ios::binary | std::ios::ate) {
  if (!stream_ || !std::filesystem::is_regular_file(file)) {
    throw InputError(file.string() + ": cannot be read: expected a recording (.mcap)");
  }
  size_ = static_cast<std::uint64_t>(stream_.tellg());
  stream_.seekg(0);
  std::string magic;
  if (!ReadBytes(std::min<std::uint64_t>(size_, kMcapMagic.size()), &magic) ||
      magic != kMcapMagic) {
    const std::string foreign = ForeignFile(file);
    throw InputError(file.string() + ": is " + (foreign.empty() ? "no MCAP file" : foreign) +
                     ": expected a recording (.mcap)");
  }
  if (!ReadRecord()) return;
  if (kind_ == McapRecord::kHeader) {
    McapUnpacker header(record_);
    header.Text();
    library_ = header.Text();
    is_fresh_ = false;
  }
}

bool McapReader::ReadBytes(std::uint64_t count, std::string* bytes) {
  bytes->resize(count);
  stream_.read(bytes->data(), static_cast<std::streamsize>(count));
  at_ += count;
  if (stream_) return true;
  Damage("it cannot be read");
  is_over_ = true;
  return false;
}

void McapReader::Skip(std::uint64_t count) {
  at_ += count;
  stream_.seekg(static_cast<std::streamoff>(at_));
}

std::optional<McapReader::Head> McapReader::ReadHead() {
  record_at_ = at_;
  std::string head;
  if (size_ - at_ >= kMcapRecordHead && ReadBytes(kMcapRecordHead, &head)) {
    McapUnpacker numbers(head);
    const auto kind = static_cast<McapRecord>(numbers.Number<std::uint8_t>());
    const auto size = numbers.Number<std::uint64_t>();
    if (size <= size_ - at_) return Head{kind, size};
  }
  is_over_ = true;
  const std::uint64_t left = size_ - record_at_;
  Damage(left > 0 ? "it is truncated: the last " + std::to_string(left) + " bytes are incomplete"
                  : "it was never closed: the last messages may be missing");
  return std::nullopt;
}

// Reads only the beginning of skipped chunks and of records that are larger than any used type.
bool McapReader::ReadRecord() {
  while (!is_over_) {
    const auto head = ReadHead();
    if (!head) return false;
    kind_ = head->kind;
    std::uint64_t left = head->size;
    record_.clear();
    if (kind_ == McapRecord::kChunk && skip_before_ > 0 && left >= kChunkHead) {
      if (!ReadBytes(kChunkHead, &record_)) return false;
      left -= kChunkHead;
      McapUnpacker times(record_);
      times.Number<std::uint64_t>();
      if (times.Number<std::uint64_t>() < skip_before_ && !channels_.empty()) {
        Skip(left);
        continue;
      }
    }
    if (left > kMaxChunk) {
      Damage("a record of " + std::to_string(left) + " bytes is skipped");
      Skip(left);
      continue;
    }
    std::string more;
    if (!ReadBytes(left, &more)) return false;
    record_ += more;
    return is_fresh_ = true;
  }
  return false;
}

// The summary, the footer and the closing magic end a file.
void McapReader::LookBehind() {
  std::string bytes;
  while (size_ - at_ >= kMcapRecordHead && ReadBytes(kMcapRecordHead, &bytes)) {
    McapUnpacker numbers(bytes);
    const auto kind = static_cast<McapRecord>(numbers.Number<std::uint8_t>());
    const auto size = numbers.Number<std::uint64_t>();
    if (size > size_ - at_) return;
    Skip(size);
    if (kind == McapRecord::kFooter) break;
  }
  const std::uint64_t end = at_ + kMcapMagic.size();
  if (size_ <= end) return;
  Skip(kMcapMagic.size());
  record_at_ = at_;
  const bool is_joined = size_ - at_ >= kMcapMagic.size() && ReadBytes(kMcapMagic.size(), &bytes) &&
                         bytes == kMcapMagic;
  Damage((is_joined ? "another recording follows: its " : "behind its end are ") +
         std::to_string(size_ - record_at_) + " bytes" +
         (is_joined ? " are not read. Separate the files" : " that are not read"));
}

bool McapReader::Next(McapMessage* message) {
  while (true) {
    while (!rest_.empty()) {
      McapUnpacker records(rest_);
      const auto kind = static_cast<McapRecord>(records.Number<std::uint8_t>());
      const std::string_view content = records.LongBytes();
      if (!records.ok()) Damage("a chunk ends in the middle of a record");
      rest_ = records.ok() ? records.rest() : std::string_view();
      if (records.ok() && kind != McapRecord::kChunk && TakeRecord(kind, content, message))
        return true;
    }
    if (is_over_ || (!is_fresh_ && !ReadRecord())) return false;
    is_fresh_ = false;
    if (TakeRecord(kind_, record_, message)) return true;
  }
}

bool McapReader::TakeRecord(McapRecord kind, std::string_view content, McapMessage* message) {
  McapUnpacker numbers(content);
  switch (kind) {
    case McapRecord::kSchema:
      TakeSchema(content);
      return false;
    case McapRecord::kChannel:
      TakeChannel(content);
      return false;
    case McapRecord::kChunk:
      TakeChunk(content);
      return false;
    case McapRecord::kAttachment:
      TakeAttachment(content);
      return false;
    case McapRecord::kMetadata: {
      const std::string name(numbers.Text());
      McapMap values = numbers.Map();
      if (numbers.ok()) notes_[name] = std::move(values);
      return false;
    }
    case McapRecord::kDataEnd:
      is_whole_ = true;
      LookBehind();
      is_over_ = true;
      return false;
    case McapRecord::kMessage:
      message->channel = numbers.Number<std::uint16_t>();
      numbers.Number<std::uint32_t>();  // sequence of the channel
      message->time = numbers.Number<std::uint64_t>();
      numbers.Number<std::uint64_t>();  // publication time, equal to the log time
      message->data = numbers.rest();
      if (!numbers.ok()) Damage("a message is too short");
      return numbers.ok() && channels_.contains(message->channel);
    default:  // indexes, and records of newer versions
      return false;
  }
}

void McapReader::TakeSchema(std::string_view content) {
  McapUnpacker fields(content);
  const auto id = fields.Number<std::uint16_t>();
  McapSchema schema{std::string(fields.Text()), std::string(fields.Text()), {}};
  schema.data = fields.Text();
  if (fields.ok() && id != 0) schemas_.try_emplace(id, std::move(schema));
}

void McapReader::TakeChannel(std::string_view content) {
  McapUnpacker fields(content);
  const auto id = fields.Number<std::uint16_t>();
  McapChannel channel;
  channel.schema = fields.Number<std::uint16_t>();
  channel.topic = fields.Text();
  fields.Text();  // encoding of the messages
  if (fields.ok()) channels_.try_emplace(id, std::move(channel));
}

void McapReader::TakeChunk(std::string_view content) {
  McapUnpacker fields(content);
  fields.Number<std::uint64_t>();  // first time
  fields.Number<std::uint64_t>();  // last time
  const auto size = fields.Number<std::uint64_t>();
  const auto crc = fields.Number<std::uint32_t>();
  const std::string_view how = fields.Text(), packed = fields.LongBytes();
  if (!fields.ok() || size > kMaxChunk) return Damage("a chunk's header is incomplete");
  auto unpacked = Unpack(packed, how, size);
  if (!unpacked) {
    const bool is_known = how.empty() || how == "zstd";
    return Damage(is_known ? "a chunk is damaged"
                           : "a chunk is compressed with " + Shown(how) +
                                 ": expected zstd or no compression");
  }
  if (crc != 0 && Crc32(*unpacked) != crc) return Damage("a chunk's checksum is wrong");
  chunk_ = *std::move(unpacked);
  rest_ = chunk_;
}

void McapReader::TakeAttachment(std::string_view content) {
  McapUnpacker fields(content);
  fields.Number<std::uint64_t>();  // recorded
  fields.Number<std::uint64_t>();  // made
  McapAttachment attachment{std::string(fields.Text()), {}};
  fields.Text();  // media type
  attachment.data = fields.LongBytes();
  const auto checked = content.substr(0, content.size() - fields.rest().size());
  const auto crc = fields.Number<std::uint32_t>();
  if (!fields.ok() || (crc != 0 && Crc32(checked) != crc)) {
    return Damage("an attached file is damaged");
  }
  attachments_.push_back(std::move(attachment));
}

const McapChannel* McapReader::channel(std::uint16_t id) const {
  const auto found = channels_.find(id);
  return found == channels_.end() ? nullptr : &found->second;
}

const McapSchema* McapReader::schema(std::uint16_t id) const {
  const auto found = schemas_.find(id);
  return found == schemas_.end() ? nullptr : &found->second;
}

// Reports the first damage only, because later ones may follow from it.
void McapReader::Damage(const std::string& what) {
  if (damage_.empty()) {
    damage_ = file_.string() + ": at byte " + std::to_string(record_at_) + ": " + what;
  }
}

}  // namespace palpate
