// The numbers of a VTK XML file's DataArray, in any of its encodings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "shared/mesh/files/file_cursor.h"
#include "shared/mesh/files/xml.h"

namespace palpate {

class VtuData {
 public:
  // `root`: the VTKFile element. Both must outlive this. Throws std::invalid_argument: an unknown
  // byte order, header type or compressor.
  VtuData(FileCursor* cursor, const XmlElement& root);

  // All numbers of an array; `count` are expected, any count if it is kAny. Throws
  // std::invalid_argument, also for numbers that are not finite.
  std::vector<double> Reals(const XmlElement& array, std::size_t count);
  std::vector<std::int64_t> Wholes(const XmlElement& array, std::size_t count);
  static constexpr auto kAny = static_cast<std::size_t>(-1);

 private:
  template <class T>
  std::vector<T> Read(const XmlElement& array, std::size_t count);
  template <class T>
  std::vector<T> ReadText(const XmlElement& array);
  // The array's bytes, decoded and inflated.
  std::string Bytes(const XmlElement& array);
  [[noreturn]] void Refuse(const XmlElement& array, const std::string& what,
                           const std::string& accepted);

  FileCursor& cursor_;
  bool little_ = true, wide_header_ = false, compressed_ = false;
  std::string_view appended_;  // behind the underscore
  bool appended_base64_ = false;
};

}  // namespace palpate
