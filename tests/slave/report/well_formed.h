// Whether a text is well-formed XML, as far as our own figures use it: elements, attributes in
// double quotes, named entities, no comments or declarations.
#pragma once

#include <cctype>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// What is wrong, with its place; empty: nothing.
inline std::string NotWellFormed(std::string_view text) {
  std::vector<std::string> open;
  std::size_t at = 0;
  bool had_root = false;
  const auto wrong = [&](const char* what) { return what + (" at " + std::to_string(at)); };
  const auto name = [&] {
    const std::size_t begin = at;
    while (at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) != 0 ||
                                text[at] == '-' || text[at] == ':')) {
      ++at;
    }
    return std::string(text.substr(begin, at - begin));
  };
  const auto entity_ends = [&] {
    for (const std::string_view entity : {"&lt;", "&gt;", "&amp;", "&quot;"}) {
      if (text.substr(at).starts_with(entity)) return true;
    }
    return false;
  };
  while (at < text.size()) {
    if (text[at] == '&' && !entity_ends()) return wrong("bare &");
    if (text[at] != '<') {
      const auto c = static_cast<unsigned char>(text[at]);
      if (open.empty() && std::isspace(c) == 0) return wrong("text outside the root");
      if (c < 0x20 && c != '\n') return wrong("control character");
      ++at;
      continue;
    }
    if (text.substr(at).starts_with("</")) {
      at += 2;
      const std::string closed = name();
      if (open.empty() || open.back() != closed) return wrong("wrong closing element");
      open.pop_back();
      if (at >= text.size() || text[at] != '>') return wrong("no >");
      ++at;
      continue;
    }
    ++at;
    const std::string element = name();
    if (element.empty()) return wrong("no element name");
    if (open.empty() && had_root) return wrong("second root");
    had_root = true;
    while (at < text.size() && text[at] == ' ') {
      ++at;
      if (name().empty()) return wrong("no attribute name");
      if (!text.substr(at).starts_with("=\"")) return wrong("attribute without quotes");
      for (at += 2; at < text.size() && text[at] != '"'; ++at) {
        if (text[at] == '<') return wrong("< in an attribute");
        if (text[at] == '&' && !entity_ends()) return wrong("bare & in an attribute");
      }
      ++at;
    }
    if (text.substr(at).starts_with("/>")) {
      at += 2;
    } else if (at < text.size() && text[at] == '>') {
      ++at;
      open.push_back(element);
    } else {
      return wrong("unfinished element");
    }
  }
  if (!open.empty()) return "not closed: " + open.back();
  return had_root ? "" : "no element";
}

}  // namespace palpate
