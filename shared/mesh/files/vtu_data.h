// The numbers of a VTK XML file's DataArray, in any of its encodings.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "shared/mesh/files/file_cursor.h"

namespace palpate {

// Views into the file's text.
struct XmlElement {
  std::string_view name;
  std::vector<std::pair<std::string_view, std::string_view>> attributes;
  std::vector<XmlElement> children;
  std::string_view text;     // behind the opening tag, up to the first child or the end
  std::size_t position = 0;  // of the opening tag in the file

  // Empty: there is none.
  [[nodiscard]] std::string_view Attribute(std::string_view key) const;
  // The first child of that name; nullptr: there is none.
  [[nodiscard]] const XmlElement* Child(std::string_view child) const;
};

// The file's root element. Behind the opening tag of an element `verbatim` nothing is parsed: its
// text reaches to the end of the file, and the elements around it end there. Throws
// std::invalid_argument: what is not well formed, more than 16 elements inside each other.
XmlElement ParseXml(FileCursor* cursor, std::string_view verbatim);

// Bytes that a text holds as they are or in base64, taken piece by piece.
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

  FileCursor& cursor_;
  bool little_ = true, wide_header_ = false, compressed_ = false;
  std::string_view appended_;  // behind the underscore
  bool appended_base64_ = false;
};

}  // namespace palpate
