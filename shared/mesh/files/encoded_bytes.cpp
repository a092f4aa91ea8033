#include "shared/mesh/files/encoded_bytes.h"

#include <cstdint>

#include <zlib.h>

namespace palpate {
namespace {

// Deflate packs 1032 bytes into one at best; a header that promises more is wrong.
constexpr std::size_t kDensest = 1032;

int Digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

}  // namespace

bool EncodedBytes::DecodeFour() {
  std::uint32_t bits = 0;
  int padding = 0;
  for (int i = 0; i < 4; ++i) {
    position_ = text_.find_first_not_of(" \t\r\n", position_);
    if (position_ == std::string_view::npos) return false;
    const char c = text_[position_++];
    const int digit = Digit(c);
    if (c == '=' && i >= 2) {
      ++padding;
    } else if (digit < 0 || padding > 0) {
      return false;
    }
    bits = bits << 6U | static_cast<std::uint32_t>(c == '=' ? 0 : digit);
  }
  for (int i = 0; i < 3 - padding; ++i) {
    decoded_ += static_cast<char>(bits >> (16U - 8U * static_cast<unsigned>(i)) & 0xffU);
  }
  return true;
}

std::optional<std::string> EncodedBytes::Take(std::size_t count) {
  if (count > text_.size()) return std::nullopt;
  if (!base64_) {
    if (count > text_.size() - position_) return std::nullopt;
    position_ += count;
    return std::string(text_.substr(position_ - count, count));
  }
  while (decoded_.size() < count) {
    if (position_ >= text_.size() || !DecodeFour()) return std::nullopt;
  }
  std::string taken = decoded_.substr(0, count);
  decoded_.erase(0, count);
  return taken;
}

std::optional<std::string> Inflated(std::string_view compressed, std::size_t size) {
  if (size / kDensest > compressed.size()) return std::nullopt;
  std::string inflated(size, '\0');
  uLongf written = size;
  const int error = uncompress(reinterpret_cast<Bytef*>(inflated.data()), &written,
                               reinterpret_cast<const Bytef*>(compressed.data()),
                               static_cast<uLong>(compressed.size()));
  if (error != Z_OK || written != size) return std::nullopt;
  return inflated;
}

}  // namespace palpate
