#include "slave/scene/document.h"

#include <algorithm>
#include <cstddef>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <unordered_map>
#include <utility>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include "shared/text/file_format.h"
#include "shared/text/text.h"
#include "slave/scene/units.h"

namespace palpate {
namespace {

constexpr std::uintmax_t kMaxFile = 1 << 20;  // [bytes]
constexpr int kDeepest = 32;
constexpr int kMaxValues = 100'000;        // aliases count each time they are used
constexpr std::size_t kMaxText = 4 << 20;  // [bytes] of keys and values, aliases spelled out
constexpr std::size_t kMaxMistakes = 50;
constexpr std::size_t kMaxQuoteLength = 60;
// Longest text of accepted values, which may name files.
constexpr std::size_t kMaxTextLength = 2000;
constexpr int kAfterTheFile = std::numeric_limits<int>::max();

using Kind = DocumentNode::Kind;

DocumentNode EmptyMap() {
  DocumentNode map;
  map.kind = Kind::kMap;
  return map;
}

bool IsDigit(char c) {
  return c >= '0' && c <= '9';
}

// Returns the value on one line, as it might be in the file.
std::string Quote(const DocumentNode& node) {
  if (node.kind == Kind::kNothing) return "(nothing)";
  if (node.kind == Kind::kScalar) return node.text;
  const bool is_map = node.kind == Kind::kMap;
  std::string text(1, is_map ? '{' : '[');
  for (const auto& child : node.children) {
    if (text.size() > kMaxQuoteLength) break;
    if (text.size() > 1) text += ", ";
    if (is_map) text += child.key + ": ";
    text += Quote(child);
  }
  return text + (is_map ? '}' : ']');
}

// Returns at most `most` bytes of whole characters, followed by dots if shortened.
std::string Shortened(std::string_view text, std::size_t most = kMaxQuoteLength) {
  constexpr int kKindOfByte = 0xc0, kInsideCharacter = 0x80;
  while (most > 0 && most < text.size() && (text[most] & kKindOfByte) == kInsideCharacter) --most;
  std::string shortened(text.substr(0, most));
  for (char& c : shortened) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return text.size() <= most ? shortened : shortened + "...";
}

// Copies yaml-cpp's tree, whose aliases may share nodes or even contain themselves.
class Copier {
 public:
  // `path`: of the value that is copied.
  Copier(Mistakes* mistakes, bool is_override, std::string path = {})
      : mistakes_(mistakes), is_override_(is_override), path_(std::move(path)) {}

  // Throws std::length_error if the tree is too deep or has too many or too long values.
  DocumentNode Copy(const YAML::Node& from, int depth = 0) {
    if (depth > kDeepest || ++values_ > kMaxValues) RefuseSize();
    DocumentNode node;
    node.line = from.Mark().line + 1;
    node.is_override = is_override_;
    if (from.IsScalar()) {
      node.kind = Kind::kScalar;
      node.text = Counted(from.Scalar());
    } else if (from.IsSequence()) {
      node.kind = Kind::kList;
      for (const auto& item : from) {
        std::string index = std::to_string(node.children.size());
        node.children.push_back(CopyChild(item, std::move(index), depth));
      }
      if (IsSplitByComma(from)) {
        mistakes_->Add(node, path_, "a blank behind each comma of a list with units");
      }
    } else if (from.IsMap()) {
      node.kind = Kind::kMap;
      CopyEntries(from, depth, &node);
    }
    return node;
  }

 private:
  [[noreturn]] static void RefuseSize() {
    throw std::length_error("at most " + std::to_string(kDeepest) + " levels, " +
                            std::to_string(kMaxValues) +
                            " values and 4 MiB of text, aliases spelled out");
  }

  // Returns whether a list such as `[0,5 mm, 0]` was written, which YAML reads as three values.
  static bool IsSplitByComma(const YAML::Node& list) {
    for (std::size_t i = 1; i < list.size(); ++i) {
      const YAML::Node first = list[i - 1], second = list[i];
      if (!first.IsScalar() || !second.IsScalar()) return false;
      const std::string &whole = first.Scalar(), &rest = second.Scalar();
      const bool has_unit = rest.find_first_of(" mkGMNPu") != std::string::npos;
      const bool is_number = !whole.empty() && std::ranges::all_of(whole, IsDigit) &&
                             !rest.empty() && IsDigit(rest[0]);
      const YAML::Mark at = first.Mark(), next = second.Mark();
      const bool touches =
          next.line == at.line && next.column == at.column + static_cast<int>(whole.size()) + 1;
      if (has_unit && is_number && touches) return true;
    }
    return false;
  }

  const std::string& Counted(const std::string& text) {
    text_ += text.size();
    if (text_ > kMaxText) RefuseSize();
    return text;
  }

  DocumentNode CopyChild(const YAML::Node& from, std::string key, int depth) {
    const std::size_t above = path_.size();
    if (above > 0) path_ += '.';
    path_ += key;
    DocumentNode child = Copy(from, depth + 1);
    child.key = std::move(key);
    path_.resize(above);
    return child;
  }

  void CopyEntries(const YAML::Node& from, int depth, DocumentNode* map) {
    std::unordered_map<std::string, int> lines;  // of the keys so far
    for (const auto& entry : from) {
      const YAML::Node& key = entry.first;
      const int line = key.Mark().line + 1;
      if (!key.IsScalar()) {
        mistakes_->AddGeneral(line, "a key is not a plain word", "`key: value`");
        continue;
      }
      if (entry.second.IsNull() && !key.Scalar().empty() && IsDigit(key.Scalar()[0])) {
        mistakes_->AddGeneral(line, "`," + Shortened(key.Scalar()) + "`: a decimal comma",
                              "a decimal point, 127.5 kPa");
        continue;
      }
      DocumentNode child = CopyChild(entry.second, Counted(key.Scalar()), depth);
      child.line = line;
      if (const auto [first, is_new] = lines.try_emplace(child.key, line); !is_new) {
        mistakes_->Add(child, path_.empty() ? child.key : path_ + "." + child.key,
                       "each key once: it is already in line " + std::to_string(first->second));
      } else {
        map->children.push_back(std::move(child));
      }
    }
  }

  Mistakes* mistakes_;
  bool is_override_;
  std::string path_;
  int values_ = 0;
  std::size_t text_ = 0;  // [bytes]
};

// `127,5 kPa`, or a list that such a comma has split, `[40, 5 mm]`.
bool HasDecimalComma(const DocumentNode& node) {
  const auto begins = [](const std::string& text) { return !text.empty() && IsDigit(text[0]); };
  if (node.kind == Kind::kScalar) {
    const std::size_t comma = node.text.find(',');
    return comma != std::string::npos && comma > 0 && comma + 1 < node.text.size() &&
           IsDigit(node.text[comma - 1]) && IsDigit(node.text[comma + 1]);
  }
  for (std::size_t i = 1; node.kind == Kind::kList && i < node.children.size(); ++i) {
    const std::string &first = node.children[i - 1].text, &second = node.children[i].text;
    const bool has_unit = second.find_first_of(" mkMGNPu") != std::string::npos;
    if (!first.empty() && first[0] != '0' && std::ranges::all_of(first, IsDigit) &&
        begins(second) && has_unit) {
      return true;
    }
  }
  return false;
}
constexpr std::string_view kMissing = "missing";
constexpr std::string_view kPoint = "decimal comma: expected a decimal point";

// Returns a hint if a tab, or a character that looks like another one, is the reason for invalid
// YAML.
std::string HintAt(const std::string& text, int line) {
  std::istringstream lines(text);
  std::string one;
  for (int number = 1; std::getline(lines, one); ++number) {
    const std::size_t content = one.find_first_not_of(" \t");
    if (one.substr(0, content).find('\t') != std::string::npos) {
      return "; line " + std::to_string(number) + " begins with a tab: expected blanks";
    }
    if (number >= line) return CodesIn(one);
  }
  return {};
}

// Returns whether these bytes are text, which has no control characters except tab and line ends.
bool IsText(const std::string& bytes) {
  return std::ranges::none_of(bytes, [](char c) {
    const auto code = static_cast<unsigned char>(c);
    return (code < 0x20 && c != '\t' && c != '\n' && c != '\r') || code == 0x7f;
  });
}

// Returns whether a document may have these bytes, and reports a mistake if not.
bool IsDocument(const std::string& bytes, Mistakes* mistakes) {
  if (const std::string foreign = ForeignFormat(std::string_view(bytes)); !foreign.empty()) {
    mistakes->AddGeneral(0, "is " + foreign, "a YAML file");
    return false;
  }
  const bool is_utf16 =
      bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF") || bytes.find('\0') < 2;
  if (is_utf16) {
    mistakes->AddGeneral(0, "text in UTF-16", "UTF-8");
    return false;
  }
  if (const std::size_t at = FindInvalidUtf8(bytes); at != std::string::npos && IsText(bytes)) {
    const auto line =
        std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(at), '\n');
    mistakes->AddGeneral(
        static_cast<int>(line) + 1,
        Formatted("byte 0x%02X is not UTF-8", static_cast<unsigned char>(bytes[at])),
        "a scene in UTF-8");
    return false;
  }
  if (!IsText(bytes)) {
    mistakes->AddGeneral(0, "not text", "a YAML file");
    return false;
  }
  return true;
}

std::optional<std::string> ReadText(const std::filesystem::path& file, Mistakes* mistakes) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    if (std::filesystem::exists(file, error)) {
      mistakes->AddGeneral(0, "not a file", "a YAML file");
    } else {
      mistakes->AddGeneral(0, "no such file");
    }
    return std::nullopt;
  }
  if (std::filesystem::file_size(file, error) > kMaxFile || error) {
    mistakes->AddGeneral(0, "too large", "at most 1 MiB");
    return std::nullopt;
  }
  std::ifstream stream(file, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) {
    mistakes->AddGeneral(0, "cannot be read");
    return std::nullopt;
  }
  if (!IsDocument(bytes, mistakes)) return std::nullopt;
  return bytes;
}

// Stores only the start position of the last document.
class DocumentStart final : public YAML::EventHandler {
 public:
  [[nodiscard]] int line() const { return line_; }
  void OnDocumentStart(const YAML::Mark& mark) override { line_ = mark.line + 1; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}

 private:
  int line_ = 0;
};

// Returns the line where a second document begins, 0 if there is none. Parsing ends there: a comma
// outside of a list makes yaml-cpp return documents without end.
int SecondDocument(const std::string& text) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStart start;
  const bool has_second = parser.HandleNextDocument(start) && parser.HandleNextDocument(start);
  return has_second ? start.line() : 0;
}

DocumentNode Parse(const std::string& text, Mistakes* mistakes) {
  DocumentNode root;
  try {
    const int second = SecondDocument(text);
    if (second == 0) root = Copier(mistakes, false).Copy(YAML::Load(text));
    if (second > 0) {
      mistakes->AddGeneral(second, "a second document", "one");
    } else if (root.kind != Kind::kMap) {
      mistakes->AddGeneral(0, root.kind == Kind::kNothing ? "empty" : "not a scene",
                           "a map of name, object, model, ...");
    }
  } catch (const YAML::Exception& error) {
    mistakes->AddGeneral(error.mark.line + 1,
                         "not YAML: " + Shortened(error.msg, 2 * kMaxQuoteLength) +
                             HintAt(text, error.mark.line + 1));
  } catch (const std::length_error& error) {
    mistakes->AddGeneral(0, "too deep or too large", error.what());
  }
  if (root.kind != Kind::kMap) root = EmptyMap();
  return root;
}

// Returns the child of a list or map for a segment of a key path; creates it in a map if it is
// missing.
DocumentNode* Descend(DocumentNode* node, const std::string& segment) {
  if (node->kind == Kind::kNothing) node->kind = Kind::kMap;
  if (node->kind == Kind::kScalar) return nullptr;
  const auto found = std::ranges::find(node->children, segment, &DocumentNode::key);
  if (found != node->children.end()) return &*found;
  if (node->kind == Kind::kList) return nullptr;
  DocumentNode made;
  made.key = segment;
  made.is_override = true;
  return &node->children.emplace_back(std::move(made));
}

void Override(const std::string& pair, DocumentNode* root, Mistakes* mistakes) {
  const auto equals = pair.find('=');
  const std::string path = pair.substr(0, equals);
  if (equals == std::string::npos || path.empty() || FindInvalidUtf8(pair) != std::string::npos) {
    mistakes->AddOverride(pair, "key.path=value in UTF-8");
    return;
  }
  const auto refuse = [&](const std::string& accepted) {
    mistakes->AddOverride(Shortened(path) + " = " + Shortened(pair.substr(equals + 1)), accepted);
  };
  DocumentNode value;
  try {
    value = Copier(mistakes, true, path).Copy(YAML::Load(pair.substr(equals + 1)));
  } catch (const std::exception& error) {
    return refuse(std::string("a YAML value (") + error.what() + ")");
  }
  DocumentNode* node = root;
  for (std::size_t begin = 0; node != nullptr && begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    node = Descend(node, path.substr(begin, end - begin));
    begin = end + 1;
  }
  if (node == nullptr) {
    return refuse("a key path that leads through maps and list indices of the scene");
  }
  value.key = node->key;
  *node = std::move(value);
}

}  // namespace

const DocumentNode* DocumentNode::Find(std::string_view child_key) const {
  if (kind == Kind::kList) {
    const auto index = ParseInteger(child_key);
    const bool is_here = index && std::cmp_less(*index, children.size()) && *index >= 0;
    return is_here ? &children[static_cast<std::size_t>(*index)] : nullptr;
  }
  const auto found = std::ranges::find(children, child_key, &DocumentNode::key);
  return found == children.end() ? nullptr : &*found;
}

bool Mistakes::is_full() const {
  return mistakes_.size() >= kMaxMistakes;
}

void Mistakes::Push(Mistake mistake) {
  ++count_;
  if (is_full()) return;
  mistake.what.expected = Shortened(mistake.what.expected, kMaxTextLength);
  mistakes_.push_back(std::move(mistake));
}

void Mistakes::Add(const DocumentNode& node, std::string_view path, std::string_view accepted) {
  const std::string quoted = Quote(node);
  Push({node.is_override,
        {.key = Shortened(path) + CodesIn(path),
         .value = Shortened(quoted) + CodesIn(quoted),
         .message = std::string(HasDecimalComma(node) ? kPoint : std::string_view()),
         .expected = std::string(accepted),
         .line = std::max(node.line, 1)}});
}

void Mistakes::AddMissing(const DocumentNode& parent, std::string_view path,
                          std::string_view accepted) {
  Push({parent.is_override,
        {.key = Shortened(path),
         .message = std::string(kMissing),
         .expected = std::string(accepted),
         .line = std::max(parent.line, 1)}});
}

void Mistakes::AddAtPath(const DocumentNode& root, std::string_view path,
                         std::string_view accepted) {
  const DocumentNode* node = &root;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const DocumentNode* child = node->Find(path.substr(begin, end - begin));
    if (child == nullptr) return AddMissing(*node, path, accepted);
    node = child;
    begin = end + 1;
  }
  Add(*node, path, accepted);
}

void Mistakes::AddGeneral(int line, std::string_view what, std::string_view accepted) {
  Push({false, {.message = std::string(what), .expected = std::string(accepted), .line = line}});
}

void Mistakes::AddOverride(std::string_view pair, std::string_view accepted) {
  Push({true,
        {.message = Shortened(pair, 2 * kMaxQuoteLength + 10), .expected = std::string(accepted)}});
}

// In the file's order, overrides last.
std::vector<Mistakes::Mistake> Mistakes::Sorted() const {
  std::vector<Mistake> sorted = mistakes_;
  std::ranges::stable_sort(sorted, {}, [](const Mistake& mistake) {
    return mistake.is_override ? kAfterTheFile : mistake.what.line;
  });
  return sorted;
}

std::string Mistakes::TextOf(const Mistake& mistake) const {
  const auto& [key, value, message, expected, line] = mistake.what;
  std::string text = mistake.is_override ? "--override " : file_;
  if (!mistake.is_override) text += (line > 0 ? ":" + std::to_string(line) : "") + ": ";
  if (key.empty()) {
    text += message;
  } else if (message == kMissing) {
    text += key + " = (missing)";
  } else {
    text += key + " = " + value + (message.empty() ? "" : " (" + message + ")");
  }
  return expected.empty() ? text : text + ": expected " + expected;
}

std::string Mistakes::text() const {
  std::string text;
  for (const Mistake& mistake : Sorted()) text += (text.empty() ? "" : "\n") + TextOf(mistake);
  if (count_ > mistakes_.size()) {
    text += "\n" + file_ + ": and " + std::to_string(count_ - mistakes_.size()) + " more mistakes";
  }
  return text;
}

std::vector<SceneMistake> Mistakes::list() const {
  std::vector<SceneMistake> list;
  for (Mistake& mistake : Sorted()) list.push_back(std::move(mistake.what));
  return list;
}

DocumentNode ReadDocument(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides, Mistakes* mistakes) {
  const auto text = ReadText(file, mistakes);
  if (!text) return EmptyMap();
  DocumentNode root = Parse(*text, mistakes);
  for (const auto& pair : overrides) Override(pair, &root, mistakes);
  return root;
}

DocumentNode ParseDocument(const std::string& text, Mistakes* mistakes) {
  if (text.size() > kMaxText) {
    mistakes->AddGeneral(0, "too large", "at most 4 MiB");
    return EmptyMap();
  }
  return IsDocument(text, mistakes) ? Parse(text, mistakes) : EmptyMap();
}

}  // namespace palpate
