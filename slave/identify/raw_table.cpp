#include "slave/identify/raw_table.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <utility>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate::identify {
namespace {

constexpr std::array<std::pair<std::string_view, double>, 21> kUnits{
    {{"pa", 1},    {"kpa", 1e3}, {"mpa", 1e6}, {"gpa", 1e9}, {"n/mm2", 1e6}, {"n/mm^2", 1e6},
     {"n/m2", 1},  {"n", 1},     {"mn", 1e-3}, {"kn", 1e3},  {"m", 1},       {"mm", 1e-3},
     {"um", 1e-6}, {"cm", 1e-2}, {"s", 1},     {"ms", 1e-3}, {"min", 60},    {"%", 0.01},
     {"-", 1},     {"1", 1},     {"mm/mm", 1}}};

std::optional<double> UnitOf(std::string_view word) {
  if (Trimmed(word) == "mPa") return 1e-3;  // the two whose first letter's size matters
  if (Trimmed(word) == "MN") return 1e6;
  std::string small(Trimmed(word));
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const auto& [name, factor] : kUnits) {
    if (name == small) return factor;
  }
  return std::nullopt;
}

// `Load (N)`, `Strain [-]`, `P_MPa`.
RawColumn ColumnOf(std::string_view title) {
  RawColumn column{std::string(title), std::string(title), std::nullopt};
  const auto cut = [&](std::size_t at, std::string_view unit) {
    column.to_si = UnitOf(unit);
    if (column.to_si) column.name.resize(at);
  };
  const std::size_t open = title.find_first_of("([");
  if (open != std::string_view::npos) {
    const std::size_t close = std::min(title.find_first_of(")]", open), title.size());
    cut(open, title.substr(open + 1, close - open - 1));
  } else if (const std::size_t bar = title.rfind('_'); bar != std::string_view::npos) {
    // `stretch_1` is the first, not one without unit.
    if (title.substr(bar + 1) != "1") cut(bar, title.substr(bar + 1));
  }
  std::string name;
  for (const char c : Trimmed(column.name)) {
    name += c == '_' ? ' ' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  column.name = name;
  return column;
}

bool IsNumbers(const std::vector<std::string_view>& cells) {
  return std::ranges::all_of(cells, [](std::string_view c) { return ParseFinite(c).has_value(); });
}

bool HasWord(const std::vector<std::string_view>& cells) {
  return cells.size() >= 2 && !std::ranges::any_of(cells, [](std::string_view cell) {
           return ParseFinite(cell).has_value();
         });
}

// A comma at the end of a row is none too many.
std::vector<std::string_view> CellsOf(const CsvLines& lines) {
  std::vector<std::string_view> cells = lines.cells();
  if (cells.size() > 2 && cells.back().empty()) cells.pop_back();
  return cells;
}

void AddRow(const CsvLines& lines, RawTable* table) {
  const auto cells = CellsOf(lines);
  if (cells.size() != table->columns.size()) {
    lines.Fail(Formatted("%zu cells: accepted is %zu, the count of the header", cells.size(),
                         table->columns.size()));
  }
  std::vector<double> row;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto number = ParseFinite(cells[c]);
    if (!number) {
      lines.Fail(table->columns[c].title + " = " + Shown(cells[c]) +
                 ": accepted is a finite number");
    }
    row.push_back(*number);
  }
  table->rows.push_back(std::move(row));
  table->lines.push_back(lines.number());
}

}  // namespace

std::optional<std::size_t> RawTable::Find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) {
    const auto found = std::ranges::find(columns, name, &RawColumn::name);
    if (found != columns.end()) return static_cast<std::size_t>(found - columns.begin());
  }
  return std::nullopt;
}

std::size_t RawTable::Named(const std::string& title) const {
  auto found = std::ranges::find(columns, title, &RawColumn::title);
  if (found == columns.end()) found = std::ranges::find(columns, title, &RawColumn::name);
  if (found == columns.end()) {
    throw InputError(file.string() + ": no column " + Shown(title) + ": accepted is one of " +
                     Titles());
  }
  return static_cast<std::size_t>(found - columns.begin());
}

std::string RawTable::Titles() const {
  std::string all;
  for (const RawColumn& column : columns) all.append(all.empty() ? "" : ", ").append(column.title);
  return Shown(all, 300);
}

RawTable ReadRawTable(const std::filesystem::path& file) {
  RawTable table{.file = file};
  CsvLines lines(file);
  while (lines.Next()) {
    const auto cells = CellsOf(lines);
    if (table.rows.empty() && HasWord(cells)) {
      table.columns.clear();
      for (const std::string_view cell : cells) table.columns.push_back(ColumnOf(cell));
    } else if (!table.rows.empty() || (cells.size() >= 2 && IsNumbers(cells))) {
      if (table.columns.empty()) {
        lines.Fail("numbers without a header: accepted is a line of column names above them");
      }
      AddRow(lines, &table);
    } else if (!table.columns.empty()) {
      AddRow(lines, &table);  // which says what is wrong with it
    }
  }
  if (table.columns.empty()) throw InputError(file.string() + ": no header: accepted is CSV");
  if (table.rows.empty()) throw InputError(file.string() + ": no row of numbers");
  return table;
}

}  // namespace palpate::identify
