// Compression (zstd) and checksum (CRC-32 of zlib) of MCAP chunks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

inline constexpr std::string_view kZstd = "zstd";

std::uint32_t Crc32(std::string_view bytes);

// Compresses chunks one after another, and reuses its buffers.
class ChunkPacker {
 public:
  ChunkPacker();
  ~ChunkPacker();
  ChunkPacker(const ChunkPacker&) = delete;
  ChunkPacker& operator=(const ChunkPacker&) = delete;

  // Overwrites `packed`. False: out of memory.
  [[nodiscard]] bool Pack(std::string_view bytes, std::string* packed);

 private:
  void* context_;
};

// Decompresses a chunk of compression `how` ("" or "zstd") and uncompressed `size` [bytes].
// nullopt: unknown compression, damaged, or another size. Never uses more memory than `size`.
std::optional<std::string> Unpack(std::string_view bytes, std::string_view how, std::size_t size);

}  // namespace palpate
