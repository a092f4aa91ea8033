// Typed reading of one map of a scene by the table of keys: all mistakes are collected, and every
// key that was not read is reported when the section ends.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slave/scene/document.h"
#include "slave/scene/keys.h"

namespace palpate {

// "a length > 0 (m, mm, um, nm, km)".
std::string AcceptedBy(const Rule& rule);

class Section {
 public:
  // `node` nullptr: the section is absent, so optional values have their defaults and missing ones
  // are not reported. All references must outlive the section. A list is read like a map whose keys
  // are 0, 1, ...
  Section(const DocumentNode* node, std::string path, Mistakes* mistakes,
          DocumentNode::Kind kind = DocumentNode::Kind::kMap);
  ~Section();  // reports the keys that were not read
  Section(const Section&) = delete;
  Section& operator=(const Section&) = delete;

  [[nodiscard]] bool present() const { return node_ != nullptr; }
  // Returns whether the key is present, and marks it as known.
  bool Has(std::string_view key);
  // Returns the map below `key`; absent if it is missing. `required`: description of the accepted
  // value if the key is required.
  Section Open(std::string_view key, std::string_view required = {});
  Section OpenList(std::string_view key, std::string_view required = {});
  [[nodiscard]] std::size_t size() const { return node_ == nullptr ? 0 : node_->children.size(); }

  // Reads a number; unit, range and default are those of the table. `fallback`: a default that the
  // reader computes; without one in either place the key is required, or zero where the table says
  // so. After a mistake the default, or zero, is returned.
  double Number(std::string_view key, std::optional<double> fallback = {});
  // A range that depends on other keys.
  double NumberWithin(std::string_view key, const Rule& rule, std::optional<double> fallback = {});
  // A whole number, with its unit if it has one.
  int Integer(std::string_view key, std::optional<int> fallback = {});
  int IntegerWithin(std::string_view key, const Rule& rule, std::optional<int> fallback = {});
  std::string Text(std::string_view key);
  std::string Text(std::string_view key, std::string_view accepted,
                   const std::optional<std::string>& fallback = {});
  // One number per rule, as a list.
  std::vector<double> Numbers(std::string_view key, std::span<const Rule> rules,
                              const std::optional<std::vector<double>>& fallback = {});
  Eigen::Vector3d Vector3(std::string_view key, std::optional<Eigen::Vector3d> fallback = {});
  Eigen::Vector2d Vector2(std::string_view key, std::optional<Eigen::Vector2d> fallback = {});
  // A list of [x, y].
  std::vector<Eigen::Vector2d> Points(std::string_view key);

  // A word of a table; the first row is the default.
  template <typename Value>
  struct Choice {
    std::string_view word;
    Value value;
  };
  template <typename Value>
  Value OneOf(std::string_view key, std::initializer_list<Choice<Value>> choices,
              std::string_view note = {}) {
    return OneOfTable<Value>(key, {choices.begin(), choices.size()}, note);
  }
  template <typename Value>
  Value OneOfTable(std::string_view key, std::span<const Choice<Value>> choices,
                   std::string_view note = {}) {
    std::string words;
    for (const auto& choice : choices) {
      words.append(words.empty() ? "" : " or ").append(choice.word);
    }
    words.append(note);
    const std::string word = Text(key, words, std::string(choices.front().word));
    for (const auto& choice : choices) {
      if (choice.word == word) return choice.value;
    }
    Refuse(key, words);
    return choices.front().value;
  }

  // Reports the value at `key`, or its absence, as a mistake.
  void Refuse(std::string_view key, std::string_view accepted);

  [[nodiscard]] const DocumentNode* node() const { return node_; }
  [[nodiscard]] const std::string& path() const { return path_; }
  [[nodiscard]] std::string PathOf(std::string_view key) const;
  [[nodiscard]] Mistakes* mistakes() const { return mistakes_; }

 private:
  const DocumentNode* Lookup(std::string_view key);
  const DocumentNode* Require(std::string_view key, std::string_view accepted, bool is_required);
  std::optional<double> Read(const DocumentNode& node, const std::string& path, const Rule& rule);
  std::vector<double> Vector(std::string_view key, std::size_t size,
                             std::optional<std::vector<double>> fallback);

  const DocumentNode* node_;
  std::string path_;
  Mistakes* mistakes_;
  std::vector<std::string> known_;  // keys that were read
  std::vector<bool> is_asked_;      // of the node's children
};

}  // namespace palpate
