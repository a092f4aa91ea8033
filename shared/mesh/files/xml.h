// As much of XML as VTK's files use: nested elements with attributes and text.
#pragma once

#include <cstddef>
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

}  // namespace palpate
