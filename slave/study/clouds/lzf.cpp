#include "slave/study/clouds/lzf.h"

#include <cstdint>

namespace palpate::study {

std::optional<std::string> DecompressLzf(std::string_view stream, std::size_t size) {
  std::string out;
  out.reserve(size);
  std::size_t at = 0;
  const auto next = [&]() -> std::optional<std::size_t> {
    if (at >= stream.size()) return std::nullopt;
    return static_cast<std::uint8_t>(stream[at++]);
  };
  while (const auto control = next()) {
    if (*control < 32) {
      const std::size_t run = *control + 1;
      if (run > stream.size() - at || run > size - out.size()) return std::nullopt;
      out.append(stream, at, run);
      at += run;
      continue;
    }
    std::size_t length = *control >> 5;
    if (length == 7) {
      const auto more = next();
      if (!more) return std::nullopt;
      length += *more;
    }
    length += 2;
    const auto low = next();
    if (!low) return std::nullopt;
    const std::size_t back = ((*control & 31) << 8) + *low + 1;
    if (back > out.size() || length > size - out.size()) return std::nullopt;
    // Byte by byte: what is repeated may reach into what it makes.
    for (std::size_t i = 0; i < length; ++i) out.push_back(out[out.size() - back]);
  }
  if (out.size() != size) return std::nullopt;
  return out;
}

}  // namespace palpate::study
