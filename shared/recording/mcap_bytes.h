// Numbers, strings and record types of MCAP files: little-endian, strings with a length prefix
// (mcap.dev/spec, Serialization).
#pragma once

#include <bit>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>

namespace palpate {

static_assert(std::endian::native == std::endian::little, "MCAP is little-endian");

inline constexpr std::string_view kMcapMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::uint64_t kMcapRecordHead = 9;  // kind and length of a record

enum class McapRecord : std::uint8_t {
  kHeader = 1,
  kFooter,
  kSchema,
  kChannel,
  kMessage,
  kChunk,
  kMessageIndex,
  kChunkIndex,
  kAttachment,
  kAttachmentIndex,
  kStatistics,
  kMetadata,
  kMetadataIndex,
  kSummaryOffset,
  kDataEnd,
};

using McapMap = std::map<std::string, std::string>;

// Serializes values into a string.
class McapPacker {
 public:
  explicit McapPacker(std::string* out) : out_(out) {}

  template <std::unsigned_integral T>
  McapPacker& Add(T value) {
    out_->append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  McapPacker& Add(std::string_view text) {
    Add(static_cast<std::uint32_t>(text.size()));
    out_->append(text);
    return *this;
  }
  // Adds bytes with a length prefix of eight bytes.
  McapPacker& AddBytes(std::string_view bytes) {
    Add(static_cast<std::uint64_t>(bytes.size()));
    out_->append(bytes);
    return *this;
  }
  McapPacker& Add(const McapMap& map) {
    std::string entries;
    for (const auto& [key, value] : map) McapPacker(&entries).Add(key).Add(value);
    return Add(std::string_view(entries));
  }
  McapPacker& AddRecord(McapRecord kind, std::string_view content) {
    Add(static_cast<std::uint8_t>(kind));
    return AddBytes(content);
  }

 private:
  std::string* out_;
};

// Reads serialized values. Never reads beyond the end: missing values are zero or empty, and ok()
// is then false.
class McapUnpacker {
 public:
  explicit McapUnpacker(std::string_view bytes) : rest_(bytes) {}

  template <std::unsigned_integral T>
  T Number() {
    T value = 0;
    const std::string_view bytes = Bytes(sizeof value);
    if (ok_) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  std::string_view Bytes(std::uint64_t count) {
    ok_ = ok_ && count <= rest_.size();
    if (!ok_) return {};
    const std::string_view bytes = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return bytes;
  }
  std::string_view Text() { return Bytes(Number<std::uint32_t>()); }
  std::string_view LongBytes() { return Bytes(Number<std::uint64_t>()); }
  McapMap Map() {
    McapMap map;
    McapUnpacker entries(Text());
    while (entries.ok() && !entries.empty()) {
      const std::string key(entries.Text());
      map.emplace(key, entries.Text());
    }
    ok_ = ok_ && entries.ok();
    return map;
  }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] bool empty() const { return rest_.empty(); }
  [[nodiscard]] std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
  bool ok_ = true;
};

}  // namespace palpate
