// The numbers of an array in a VTU file that WriteVtu wrote, for tests.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace palpate {

// The array whose tag contains `attribute`, such as `Name="types"`. Empty: not found.
template <class T>
std::vector<T> VtuArray(const std::string& file, const std::string& attribute) {
  const std::size_t named = file.find(attribute);
  if (named == std::string::npos) return {};
  const std::size_t tag = file.find('>', named);
  const std::string head = file.substr(named, tag - named);
  const std::string offset = " offset=\"";
  const std::size_t at = head.find(offset);
  if (at == std::string::npos) return {};
  const char* begin =
      file.data() + file.find("\n_") + 2 + std::stoul(head.substr(at + offset.size()));
  std::uint64_t size = 0;
  std::memcpy(&size, begin, sizeof size);
  std::vector<T> values(size / sizeof(T));
  std::memcpy(values.data(), begin + sizeof size, size);
  return values;
}

}  // namespace palpate
