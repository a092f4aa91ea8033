// A Section that records what the scene's readers ask it for. It is included in front of every
// source of slave/scene, so that the readers use it in place of the Section they were written for.
// Their code is the same; only this program records.
#pragma once

#include <initializer_list>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slave/scene/document.h"
#include "slave/scene/units.h"

#define Section PlainSection
#include "slave/scene/section.h"
#undef Section

namespace palpate {

// Where a reader asks. As the last parameter of a function it is where that is called.
struct Place {
  const char* file;
  int line;
  static constexpr Place Here(const char* file = __builtin_FILE(), int line = __builtin_LINE()) {
    return {file, line};
  }
};

// One question of a reader.
struct KeyRecord {
  Place place;
  std::string path;                // dotted; items of lists by their index
  std::string kind;                // number, integer, text, choice, numbers, points, map, list, has
  std::string accepted;            // range or words
  std::vector<std::string> units;  // of a number, or of each number of a list
  std::vector<std::string> words;  // of a choice; the first is the default
  std::vector<double> defaults;    // SI
  std::optional<std::string> text;  // default of a text
  bool is_required = false;         // no default, and the reader did not look whether it is there
};
std::vector<KeyRecord>& KeyRecords();

class Section : public PlainSection {
 public:
  using PlainSection::PlainSection;

  bool Has(std::string_view key);
  Section Open(std::string_view key, std::string_view required = {}, Place place = Place::Here());
  Section OpenList(std::string_view key, std::string_view required = {},
                   Place place = Place::Here());
  double Number(std::string_view key, const Rule& rule, std::optional<double> fallback = {},
                Place place = Place::Here());
  int Integer(std::string_view key, int least, int most, std::optional<int> fallback = {},
              Dimension dimension = Dimension::kNumber, Place place = Place::Here());
  std::string Text(std::string_view key, std::string_view accepted,
                   const std::optional<std::string>& fallback = {}, Place place = Place::Here());
  std::vector<double> Numbers(std::string_view key, std::span<const Rule> rules,
                              const std::optional<std::vector<double>>& fallback = {},
                              Place place = Place::Here());
  Eigen::Vector3d Vector3(std::string_view key, const Rule& rule, const Eigen::Vector3d& fallback,
                          Place place = Place::Here());
  Eigen::Vector2d Vector2(std::string_view key, const Rule& rule,
                          std::optional<Eigen::Vector2d> fallback = {},
                          Place place = Place::Here());
  std::vector<Eigen::Vector2d> Points(std::string_view key, const Rule& rule,
                                      Place place = Place::Here());

  template <typename Value>
  Value OneOf(std::string_view key, std::initializer_list<Choice<Value>> choices,
              std::string_view note = {}, Place place = Place::Here()) {
    return OneOfTable<Value>(key, {choices.begin(), choices.size()}, note, place);
  }
  template <typename Value>
  Value OneOfTable(std::string_view key, std::span<const Choice<Value>> choices,
                   std::string_view note = {}, Place place = Place::Here()) {
    KeyRecord record = RecordOf(key, "choice", note, place);
    for (const auto& choice : choices) record.words.emplace_back(choice.word);
    KeyRecords().push_back(record);
    return PlainSection::OneOfTable<Value>(key, choices, note);
  }

 private:
  [[nodiscard]] KeyRecord RecordOf(std::string_view key, std::string_view kind,
                                   std::string_view accepted, Place place) const;
  void RecordNumbers(std::string_view key, std::string_view kind, std::span<const Rule> rules,
                     const std::optional<std::vector<double>>& fallback, Place place);
  Section OpenKind(std::string_view key, std::string_view required, DocumentNode::Kind kind,
                   Place place);

  std::set<std::string, std::less<>> looked_for_;
};

}  // namespace palpate
