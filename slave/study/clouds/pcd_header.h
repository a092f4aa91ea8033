// The header of a PCD file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace palpate::study {

struct PcdField {
  std::string name;
  int size = 4;            // of one value [bytes]
  char type = 'F';         // F float, I signed, U unsigned
  std::size_t count = 1;   // values per point
  std::size_t offset = 0;  // in a point [bytes]
  std::size_t column = 0;  // of its first value
  [[nodiscard]] std::size_t bytes() const { return static_cast<std::size_t>(size) * count; }
};

struct PcdHeader {
  enum class Data : std::uint8_t { kAscii, kBinary, kCompressed } data = Data::kAscii;
  std::vector<PcdField> fields;
  std::size_t points = 0;
  std::size_t stride = 0;   // bytes of a point
  std::size_t columns = 0;  // values of a point
  std::size_t end = 0;      // where the data begin in the file [bytes]
  int lines = 0;            // of the header
  // nullptr: there is none of this name.
  [[nodiscard]] const PcdField* Find(std::string_view name) const;
};

// Reads the header of a file whose whole content is `content`; `file` is for messages. Throws
// std::invalid_argument (`file:line: ...`): no PCD file, a line missing, unknown or that
// contradicts another, more points than the file has bytes for.
PcdHeader ReadPcdHeader(const std::filesystem::path& file, std::string_view content);

}  // namespace palpate::study
