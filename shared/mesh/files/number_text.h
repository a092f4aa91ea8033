// Numbers as the shortest text that reads back as the same number, whatever the locale.
#pragma once

#include <array>
#include <charconv>
#include <string>

namespace palpate {

template <class T>
void AppendNumber(T value, char separator, std::string* text) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text->append(digits.data(), end) += separator;
}

}  // namespace palpate
