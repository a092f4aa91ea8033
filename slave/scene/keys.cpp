#include "slave/scene/keys.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

using Table = std::map<std::string, SceneKey, std::less<>>;

std::string_view Unquoted(std::string_view code) {
  return code.size() > 1 && code.front() == '`' && code.back() == '`'
             ? code.substr(1, code.size() - 2)
             : code;
}

// `[x, y], length [m]`: the quantity before the unit.
Dimension DimensionOf(std::string_view type) {
  using enum Dimension;
  constexpr std::array kQuantities{std::pair{"angular speed [", kAngularSpeed},
                                   std::pair{"length [", kLength},
                                   std::pair{"pressure [", kPressure},
                                   std::pair{"force [", kForce},
                                   std::pair{"time [", kTime},
                                   std::pair{"frequency [", kFrequency},
                                   std::pair{"angle [", kAngle},
                                   std::pair{"density [", kDensity},
                                   std::pair{"speed [", kSpeed},
                                   std::pair{"[px]", kPixels},
                                   std::pair{"tension [", kTension},
                                   std::pair{"volume [", kVolume}};
  for (const auto& [words, dimension] : kQuantities) {
    if (type.find(words) != std::string_view::npos) return dimension;
  }
  return kNumber;
}

// Parses `10 to 500 ms`, `> 0 (1 um to 1 km)`, `a whole number, 1 to 4000`, `> 0`, `>= 0` or `any`.
// For other texts the rule accepts nothing.
Rule RuleOf(Dimension dimension, std::string_view range) {
  constexpr std::string_view kTo = " to ";
  const std::size_t open = range.find('(');
  std::string_view limits = range;
  if (open != std::string_view::npos && range.find(kTo, open) != std::string_view::npos) {
    limits = range.substr(open + 1, range.find(')', open) - open - 1);
  }
  const std::size_t to = limits.find(kTo);
  if (to == std::string_view::npos) {
    if (range == "> 0") return {dimension, kMinValue, kMaxValue, range};
    if (range == ">= 0") return {dimension, 0, kMaxValue, range};
    if (range == "any") return {dimension, -kMaxValue, kMaxValue, "-1e15 to 1e15 SI"};
    return {dimension, 1, 0, range};
  }
  std::string_view most = limits.substr(to + kTo.size());
  most = most.substr(0, most.find_first_of(",;"));
  std::string least(limits.substr(0, to));
  if (const std::size_t comma = least.rfind(','); comma != std::string::npos) {
    least.erase(0, comma + 1);
  }
  const std::size_t unit = most.find(' ');
  if (Trimmed(least).find(' ') == std::string_view::npos && unit != std::string_view::npos) {
    least += most.substr(unit);
  }
  const auto low = ParseQuantity(least, dimension), high = ParseQuantity(most, dimension);
  return {dimension, low.value_or(1), high.value_or(0), range};
}

// `60 Hz`, `60 Hz; stereo: 30 Hz`, `[0, 0, 0]`.
std::vector<double> DefaultsOf(Dimension dimension, std::string_view text) {
  const bool is_list = text.starts_with('[');
  text = is_list ? text.substr(1, text.find(']') - 1) : text.substr(0, text.find(';'));
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = is_list ? std::min(text.find(',', begin), text.size()) : text.size();
    const auto number = ParseQuantity(text.substr(begin, end - begin), dimension);
    if (!number) return {};
    numbers.push_back(*number);
    begin = end + 1;
  }
  return numbers;
}

Table ReadTable() {
  Table table;
  std::string_view page = SceneKeysPage();
  while (!page.empty()) {
    const std::string_view line = page.substr(0, page.find('\n'));
    page.remove_prefix(std::min(page.size(), line.size() + 1));
    if (!line.starts_with("| `")) continue;
    const std::vector<std::string_view> cells = TableCells(line);
    if (cells.size() != 5) throw std::logic_error("table of keys: " + std::string(line));
    const Dimension dimension = DimensionOf(cells[1]);
    SceneKey& key = table[std::string(Unquoted(cells[0]))];
    key.range = cells[3];
    key.rule = RuleOf(dimension, key.range);
    key.is_required = cells[2].find("required") != std::string_view::npos;
    key.defaults = DefaultsOf(dimension, cells[2]);
    if (cells[2].starts_with('`')) key.default_text = Unquoted(cells[2]);
  }
  return table;
}

// Returns the path without list indices, and with NAME for the name of a finger.
std::string RowOf(std::string_view path) {
  std::string row;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    std::string_view part = path.substr(begin, end - begin);
    begin = end + 1;
    const bool is_finger = row == "sense.tactile.fingers";
    if (!is_finger && ParseInteger(part)) continue;
    row.append(row.empty() ? "" : ".").append(is_finger ? "NAME" : part);
  }
  return row;
}

}  // namespace

std::vector<std::string_view> TableCells(std::string_view row) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 1; begin < row.size();) {
    const std::size_t end = std::min(row.find('|', begin), row.size());
    cells.push_back(Trimmed(row.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

const SceneKey& SceneKeyAt(std::string_view path) {
  static const Table table = ReadTable();
  const auto row = table.find(RowOf(path));
  if (row == table.end()) throw std::logic_error("no row in the table of keys: " + RowOf(path));
  return row->second;
}

}  // namespace palpate
