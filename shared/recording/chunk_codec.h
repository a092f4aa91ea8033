// What a chunk of an MCAP file is packed with: zstd (libzstd), and CRC-32 (zlib).
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

inline constexpr std::string_view kZstd = "zstd";

std::uint32_t Crc32(std::string_view bytes);

// Packs one chunk after the other, with what it needs kept in between.
class ChunkPacker {
 public:
  ChunkPacker();
  ~ChunkPacker();
  ChunkPacker(const ChunkPacker&) = delete;
  ChunkPacker& operator=(const ChunkPacker&) = delete;

  // Into `packed`, overwritten. False: no memory.
  [[nodiscard]] bool Pack(std::string_view bytes, std::string* packed);

 private:
  void* context_;
};

// `bytes` of a chunk that says it is packed with `how` ("" or "zstd") and unpacks to `size` bytes.
// nullopt: another packing, damaged, another size. Never takes more memory than `size`.
std::optional<std::string> Unpack(std::string_view bytes, std::string_view how, std::size_t size);

}  // namespace palpate
