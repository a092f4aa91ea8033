#include "shared/recording/chunk_codec.h"

#include <zlib.h>
#include <zstd.h>

namespace palpate {
namespace {

constexpr int kLevel =
    1;  // fastest level: a recorder has a share of a core, and the last digits of forces are noise

}  // namespace

std::uint32_t Crc32(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

ChunkPacker::ChunkPacker() : context_(ZSTD_createCCtx()) {}

ChunkPacker::~ChunkPacker() {
  ZSTD_freeCCtx(static_cast<ZSTD_CCtx*>(context_));
}

bool ChunkPacker::Pack(std::string_view bytes, std::string* packed) {
  if (context_ == nullptr) return false;
  packed->resize(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compressCCtx(static_cast<ZSTD_CCtx*>(context_), packed->data(),
                                             packed->size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) return false;
  packed->resize(size);
  return true;
}

std::optional<std::string> Unpack(std::string_view bytes, std::string_view how, std::size_t size) {
  if (how.empty() && bytes.size() == size) return std::string(bytes);
  if (how != kZstd) return std::nullopt;
  std::string unpacked(size, '\0');
  const std::size_t taken = ZSTD_decompress(unpacked.data(), size, bytes.data(), bytes.size());
  if (ZSTD_isError(taken) != 0 || taken != size) return std::nullopt;
  return unpacked;
}

}  // namespace palpate
