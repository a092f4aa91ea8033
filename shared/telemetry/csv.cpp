#include "shared/telemetry/csv.h"

#include <array>
#include <charconv>
#include <cmath>

namespace palpate {

void AppendNumber(std::string* text, double value, int digits) {
  if (!std::isfinite(value)) return;
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                          value == 0 ? 0 : value,  // no "-0"
                                          std::chars_format::general, digits);
  text->append(buffer.data(), end);
}

}  // namespace palpate
