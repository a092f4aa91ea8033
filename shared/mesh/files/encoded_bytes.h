// Bytes that a text holds as they are or in base64, taken piece by piece.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

class EncodedBytes {
 public:
  EncodedBytes(std::string_view text, bool base64) : text_(text), base64_(base64) {}

  // The next `count` bytes; nullopt: there are fewer, or what is there is not base64. Padding in
  // the middle is passed over: VTK encodes headers and data one after the other.
  std::optional<std::string> Take(std::size_t count);

 private:
  bool DecodeFour();

  std::string_view text_;
  bool base64_;
  std::size_t position_ = 0;
  std::string decoded_;  // but not taken yet
};

// `compressed` by zlib, `size` bytes when inflated; nullopt: it is not that.
std::optional<std::string> Inflated(std::string_view compressed, std::size_t size);

}  // namespace palpate
