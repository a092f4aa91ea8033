// A scene file as a tree of text with line numbers, before interpretation. Only this file depends
// on YAML.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "slave/scene/scene_mistake.h"

namespace palpate {

struct DocumentNode {
  enum class Kind : std::uint8_t { kNothing, kScalar, kList, kMap };
  Kind kind = Kind::kNothing;
  std::string key;                     // key in its map
  std::string text;                    // of a scalar
  std::vector<DocumentNode> children;  // of a list or a map, in the file's order
  int line = 0;                        // line number from 1; 0: not in the file
  bool is_override = false;            // from the command line

  [[nodiscard]] const DocumentNode* Find(std::string_view child_key) const;
};

// Mistakes of one file, each a line `file:line: key = value: expected ...`, or `--override key =
// value: expected ...`.
class Mistakes {
 public:
  explicit Mistakes(const std::filesystem::path& file) : file_(file.string()) {}

  // The value at `node`, whose dotted key path is `path`, is not `accepted`.
  void Add(const DocumentNode& node, std::string_view path, std::string_view accepted);
  // A required value is missing at `path` in `parent`.
  void AddMissing(const DocumentNode& parent, std::string_view path, std::string_view accepted);
  // The value at the dotted `path` below `root`, or that it is missing.
  void AddAtPath(const DocumentNode& root, std::string_view path, std::string_view accepted);
  // A mistake that concerns no value, at a line or (0) the file as a whole.
  void AddGeneral(int line, std::string_view what, std::string_view accepted = {});
  // Error of an `--override` that is no pair of key and value.
  void AddOverride(std::string_view pair, std::string_view accepted);

  [[nodiscard]] std::size_t count() const { return count_; }
  // Returns whether further mistakes are only counted.
  [[nodiscard]] bool is_full() const;
  // One per line, in the file's order; of more than 50 the first that were found, and the number of
  // the others.
  [[nodiscard]] std::string text() const;
  // The mistakes of `text` as data, without the number of the others.
  [[nodiscard]] std::vector<SceneMistake> list() const;

 private:
  struct Mistake {
    bool is_override = false;
    SceneMistake what;
  };
  void Push(Mistake mistake);
  [[nodiscard]] std::vector<Mistake> Sorted() const;
  [[nodiscard]] std::string TextOf(const Mistake& mistake) const;
  std::string file_;
  std::vector<Mistake> mistakes_;
  std::size_t count_ = 0;
};

// Reads a file of at most 1 MiB: one YAML document of at most 32 levels, 100 000 values and 4 MiB
// of keys and values (aliases count each time they are used), whose root is a map. Then applies the
// `key.path=value` pairs (numbers index lists; missing maps are created). A mistake that prevents
// reading gives an empty map.
DocumentNode ReadDocument(const std::filesystem::path& file,
                          const std::vector<std::string>& overrides, Mistakes* mistakes);
// Parses the text of a file like ReadDocument, without overrides.
DocumentNode ParseDocument(const std::string& text, Mistakes* mistakes);

}  // namespace palpate
