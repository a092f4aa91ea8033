#include "shared/mesh/files/xml.h"

#include <algorithm>

namespace palpate {
namespace {

constexpr int kDeepest = 16;
constexpr std::string_view kBlanks = " \t\r\n";
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
