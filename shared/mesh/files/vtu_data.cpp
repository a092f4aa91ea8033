#include "shared/mesh/files/vtu_data.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>
#include <utility>

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

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::uint64_t kMostBytes = 4ULL << 30U;  // of one array
constexpr std::uint64_t kMostBlocks = 1U << 24U;

template <class T>
T FromBytes(const char* bytes, bool little) {
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (little != (std::endian::native == std::endian::little)) std::ranges::reverse(raw);
  return std::bit_cast<T>(raw);
}

// A stored number of type S as T; false: it is none of T's.
template <class S, class T>
bool Convert(S stored, T* value) {
  if constexpr (std::is_same_v<T, double>) {
    *value = static_cast<double>(stored);
    return std::isfinite(*value);
  } else {
    if (!std::in_range<T>(stored)) return false;
    *value = static_cast<T>(stored);
    return true;
  }
}

template <class S, class T>
bool ConvertAll(const std::string& bytes, bool little, std::vector<T>* values) {
  if (bytes.size() % sizeof(S) != 0) return false;
  values->resize(bytes.size() / sizeof(S));
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (!Convert(FromBytes<S>(bytes.data() + i * sizeof(S), little), &(*values)[i])) return false;
  }
  return true;
}

// nullopt: an unknown type. Whole numbers may stand where reals are wanted, not the other way.
template <class T>
std::optional<bool> ConvertFrom(std::string_view type, const std::string& bytes, bool little,
                                std::vector<T>* values) {
  if constexpr (std::is_same_v<T, double>) {
    if (type == "Float32") return ConvertAll<float>(bytes, little, values);
    if (type == "Float64") return ConvertAll<double>(bytes, little, values);
    return std::nullopt;
  } else {
    if (type == "Int8") return ConvertAll<std::int8_t>(bytes, little, values);
    if (type == "UInt8") return ConvertAll<std::uint8_t>(bytes, little, values);
    if (type == "Int16") return ConvertAll<std::int16_t>(bytes, little, values);
    if (type == "UInt16") return ConvertAll<std::uint16_t>(bytes, little, values);
    if (type == "Int32") return ConvertAll<std::int32_t>(bytes, little, values);
    if (type == "UInt32") return ConvertAll<std::uint32_t>(bytes, little, values);
    if (type == "Int64") return ConvertAll<std::int64_t>(bytes, little, values);
    if (type == "UInt64") return ConvertAll<std::uint64_t>(bytes, little, values);
    return std::nullopt;
  }
}

// The blocks of one array: sizes first, then, if compressed, each block inflated by itself.
class Blocks {
 public:
  Blocks(EncodedBytes bytes, bool little, bool wide)
      : bytes_(bytes), little_(little), wide_(wide) {}

  std::optional<std::string> Plain() {
    const auto size = Header();
    return size && *size <= kMostBytes ? bytes_.Take(*size) : std::nullopt;
  }

  std::optional<std::string> Unpacked() {
    const auto count = Header(), size = Header(), last = Header();
    if (!count || !size || !last || *count > kMostBlocks || *size > kMostBytes || *last > *size ||
        *count * *size > kMostBytes) {
      return std::nullopt;
    }
    std::vector<std::uint64_t> packed;
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto one = Header();
      if (!one) return std::nullopt;
      packed.push_back(*one);
    }
    std::string all;
    for (std::uint64_t i = 0; i < *count; ++i) {
      const auto block = bytes_.Take(packed[i]);
      if (!block) return std::nullopt;
      const auto inflated = Inflated(*block, i + 1 == *count && *last > 0 ? *last : *size);
      if (!inflated) return std::nullopt;
      all += *inflated;
    }
    return all;
  }

 private:
  std::optional<std::uint64_t> Header() {
    const auto raw = bytes_.Take(wide_ ? 8 : 4);
    if (!raw) return std::nullopt;
    return wide_ ? FromBytes<std::uint64_t>(raw->data(), little_)
                 : FromBytes<std::uint32_t>(raw->data(), little_);
  }

  EncodedBytes bytes_;
  bool little_, wide_;
};

constexpr int kDeepest = 16;
constexpr std::string_view kNameEnds = " \t\r\n=/><\"'";

class XmlParser {
 public:
  XmlParser(FileCursor* cursor, std::string_view verbatim)
      : cursor_(*cursor), text_(cursor->text()), verbatim_(verbatim) {}

  XmlElement Root() {
    PassToTag();
    if (closing()) Refuse("a closing tag", "an opening one");
    return Element(0);
  }

 private:
  [[noreturn]] void Refuse(const std::string& what, const std::string& accepted) {
    cursor_.RefuseAt(position_, what, accepted);
  }
  [[nodiscard]] bool closing() const { return text_.substr(position_).starts_with("</"); }

  std::size_t Find(std::string_view what) {
    const std::size_t found = text_.find(what, position_);
    if (found == std::string_view::npos) Refuse("the file ends", Quoted(what) + " before it");
    return found;
  }

  // To the next tag that is neither a comment nor an instruction.
  void PassToTag() {
    for (;;) {
      position_ = Find("<");
      const std::string_view rest = text_.substr(position_);
      if (rest.starts_with("<!--")) {
        position_ = Find("-->");
      } else if (rest.starts_with("<?") || rest.starts_with("<!")) {
        position_ = Find(">");
      } else {
        return;
      }
    }
  }

  void PassBlanks() {
    position_ = std::min(text_.find_first_not_of(kBlanks, position_), text_.size());
  }

  bool Take(std::string_view what) {
    if (!text_.substr(position_).starts_with(what)) return false;
    position_ += what.size();
    return true;
  }

  std::string_view Name() {
    const std::size_t end = std::min(text_.find_first_of(kNameEnds, position_), text_.size());
    if (end == position_) Refuse(Quoted(text_.substr(position_, 10)), "a name");
    const std::string_view name = text_.substr(position_, end - position_);
    position_ = end;
    return name;
  }

  void ReadAttribute(XmlElement* element) {
    const std::string_view key = Name();
    PassBlanks();
    if (!Take("=")) Refuse("attribute " + Quoted(key), "name=\"value\"");
    PassBlanks();
    const std::string_view quote = text_.substr(position_, 1);
    if (!Take("\"") && !Take("'")) Refuse("attribute " + Quoted(key), "a value in quotes");
    const std::size_t end = Find(quote);
    element->attributes.emplace_back(key, text_.substr(position_, end - position_));
    position_ = end + 1;
  }

  XmlElement Element(int depth) {
    XmlElement element;
    element.position = position_;
    if (depth == kDeepest) Refuse("too many elements inside each other", "16 at most");
    position_ += 1;
    element.name = Name();
    for (PassBlanks(); !Take(">"); PassBlanks()) {
      if (Take("/>")) return element;
      ReadAttribute(&element);
    }
    const std::size_t begin = position_;
    if (element.name == verbatim_) ended_ = true;
    element.text = text_.substr(begin, ended_ ? std::string_view::npos : Find("<") - begin);
    ReadChildren(&element, depth);
    return element;
  }

  void ReadChildren(XmlElement* element, int depth) {
    while (!ended_) {
      PassToTag();
      if (!closing()) {
        element->children.push_back(Element(depth + 1));
        continue;
      }
      position_ += 2;
      const std::string_view name = Name();
      if (name != element->name) {
        Refuse("the end of " + Quoted(name), "the end of " + Quoted(element->name));
      }
      position_ = Find(">") + 1;
      return;
    }
  }

  FileCursor& cursor_;
  std::string_view text_, verbatim_;
  std::size_t position_ = 0;
  bool ended_ = false;  // what is verbatim reaches to the end
};

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

VtuData::VtuData(FileCursor* cursor, const XmlElement& root) : cursor_(*cursor) {
  const std::string_view order = root.Attribute("byte_order");
  if (!order.empty() && order != "LittleEndian" && order != "BigEndian") {
    cursor_.RefuseAt(root.position, "byte_order " + Quoted(order), "LittleEndian or BigEndian");
  }
  little_ = order != "BigEndian";
  const std::string_view header = root.Attribute("header_type");
  if (!header.empty() && header != "UInt32" && header != "UInt64") {
    cursor_.RefuseAt(root.position, "header_type " + Quoted(header), "UInt32 or UInt64");
  }
  wide_header_ = header == "UInt64";
  const std::string_view compressor = root.Attribute("compressor");
  if (!compressor.empty() && compressor != "vtkZLibDataCompressor") {
    cursor_.RefuseAt(root.position, "compressor " + Quoted(compressor),
                     "vtkZLibDataCompressor or none");
  }
  compressed_ = !compressor.empty();
  if (const XmlElement* appended = root.Child("AppendedData")) {
    const std::size_t begin = appended->text.find('_');
    if (begin == std::string_view::npos)
      cursor_.RefuseAt(appended->position, "no underscore", "one before the data");
    appended_ = appended->text.substr(begin + 1);
    appended_base64_ = appended->Attribute("encoding") == "base64";
  }
}

std::string VtuData::Bytes(const XmlElement& array) {
  std::string_view text = array.text;
  bool base64 = true;
  if (array.Attribute("format") == "appended") {
    const std::int64_t offset = ParseWhole(cursor_, array.Attribute("offset"), "offset", 0,
                                           static_cast<std::int64_t>(appended_.size()));
    text = appended_.substr(static_cast<std::size_t>(offset));
    base64 = appended_base64_;
  }
  Blocks blocks(EncodedBytes(text, base64), little_, wide_header_);
  const auto bytes = compressed_ ? blocks.Unpacked() : blocks.Plain();
  if (!bytes) {
    cursor_.RefuseAt(array.position,
                     "the data of array " + Quoted(array.Attribute("Name")) + " are damaged",
                     std::string("whole ") + (base64 ? "base64" : "raw") + " data" +
                         (compressed_ ? " packed by zlib" : ""));
  }
  return *bytes;
}

template <class T>
std::vector<T> VtuData::ReadText(const XmlElement& array) {
  std::vector<T> values;
  const char* const file = cursor_.text().data();
  for (std::size_t begin = array.text.find_first_not_of(kBlanks);
       begin != std::string_view::npos;) {
    const std::size_t end = std::min(array.text.find_first_of(kBlanks, begin), array.text.size());
    const std::string_view word = array.text.substr(begin, end - begin);
    cursor_.Mark(static_cast<std::size_t>(word.data() - file));
    if constexpr (std::is_same_v<T, double>) {
      values.push_back(ParseReal(cursor_, word, "number"));
    } else {
      values.push_back(ParseWhole(cursor_, word, "number", 0, FileCursor::kMost * 30));
    }
    begin = array.text.find_first_not_of(kBlanks, end);
  }
  return values;
}

template <class T>
std::vector<T> VtuData::Read(const XmlElement& array, std::size_t count) {
  const std::string_view format = array.Attribute("format"), type = array.Attribute("type");
  std::vector<T> values;
  if (format == "ascii") {
    values = ReadText<T>(array);
  } else if (format == "binary" || format == "appended") {
    const auto converted = ConvertFrom(type, Bytes(array), little_, &values);
    if (!converted) {
      cursor_.RefuseAt(
          array.position, "type " + Quoted(type),
          std::is_same_v<T, double> ? "Float32 or Float64" : "Int8 to Int64, UInt8 to UInt64");
    }
    if (!*converted)
      cursor_.RefuseAt(array.position, "a damaged number",
                       "finite numbers of type " + Quoted(type));
  } else {
    cursor_.RefuseAt(array.position, "format " + Quoted(format), "ascii, binary or appended");
  }
  if (count != kAny && values.size() != count) {
    cursor_.RefuseAt(array.position, std::to_string(values.size()) + " numbers",
                     std::to_string(count));
  }
  return values;
}

std::vector<double> VtuData::Reals(const XmlElement& array, std::size_t count) {
  return Read<double>(array, count);
}

std::vector<std::int64_t> VtuData::Wholes(const XmlElement& array, std::size_t count) {
  return Read<std::int64_t>(array, count);
}

std::string_view XmlElement::Attribute(std::string_view key) const {
  for (const auto& [own, value] : attributes) {
    if (own == key) return value;
  }
  return {};
}

const XmlElement* XmlElement::Child(std::string_view child) const {
  const auto found = std::ranges::find(children, child, &XmlElement::name);
  return found == children.end() ? nullptr : &*found;
}

XmlElement ParseXml(FileCursor* cursor, std::string_view verbatim) {
  return XmlParser(cursor, verbatim).Root();
}

}  // namespace palpate
