// The table of scene keys: type, unit, default, range and meaning of every key, once.
//
// It is the page deploy/scenes/README.md, which the build puts into the program. Readers take
// units, ranges and defaults from it, and `palpate-slave keys` prints it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "slave/scene/units.h"

namespace palpate {

// Requirement for a number: its dimension and `least` <= x <= `most`.
struct Rule {
  Dimension dimension = Dimension::kNumber;
  double least = 0, most = 0;
  std::string_view range;  // as text: "> 0"
};

// Limits of values, far from any physical value, so that products of two or three values are finite
// numbers.
constexpr double kMinValue = 1e-15, kMaxValue = 1e15;

struct SceneKey {
  std::string default_text;      // empty: none, or the reader computes it
  std::vector<double> defaults;  // numbers in it [SI]
  bool is_required = false;
  std::string range;
  Rule rule;  // of a number, or of each number of a list
};

// `path`: dotted, as in a scene; items of lists by their index. Throws std::logic_error: the table
// has no such row.
const SceneKey& SceneKeyAt(std::string_view path);

// Cells of a row `| a | b |` of Markdown, trimmed.
std::vector<std::string_view> TableCells(std::string_view row);

// The page with the tables, Markdown.
std::string_view SceneKeysPage();

}  // namespace palpate
