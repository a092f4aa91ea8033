#include "slave/identify/raw_table.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "shared/text/csv.h"
#include "shared/text/text.h"

namespace palpate::identify {
namespace {

RawColumn ColumnOf(std::string_view title) {
  return {SplitFreeTitle(title), std::string(title)};
}

constexpr std::size_t kMaxRemarks = 3;  // lines of numbers above a header

std::ptrdiff_t CountNumbers(const std::vector<std::string_view>& cells) {
  return std::ranges::count_if(cells,
                               [](std::string_view c) { return ParseFinite(c).has_value(); });
}

bool HasWord(const std::vector<std::string_view>& cells) {
  return cells.size() >= 2 && CountNumbers(cells) == 0;
}

// Returns whether this is a row of data: it begins with a number, or has two numbers below as many
// names.
bool IsRow(const std::vector<std::string_view>& cells, std::size_t columns) {
  const bool begins = cells.size() >= 2 && ParseFinite(cells.front()).has_value();
  return begins || (cells.size() == columns && CountNumbers(cells) >= 2);
}

// Below the names: short words, and a unit or brackets in half of them or more. Instruments also
// write temperatures and the like.
bool IsRowOfUnits(const std::vector<std::string_view>& cells, std::size_t columns) {
  constexpr std::size_t kMaxUnitLength = 8;
  if (cells.size() != columns) return false;
  std::size_t words = 0, units = 0;
  for (const std::string_view cell : cells) {
    if (cell.empty()) continue;
    const bool is_unit = cell.front() == '(' || cell.front() == '[' || FindUnit(cell).has_value();
    if (!is_unit && cell.size() > kMaxUnitLength) return false;
    ++words;
    units += is_unit ? 1 : 0;
  }
  return units > 0 && 2 * units >= words;
}

// Returns whether two columns with the same name have the same numbers in SI, that is, one quantity
// in two units. Columns of different specimens differ.
bool IsSame(const RawTable& table, std::size_t a, std::size_t b) {
  constexpr double kRounding = 0.01;  // relative to the largest number
  const double of_a = table.columns[a].to_si.value_or(1), of_b = table.columns[b].to_si.value_or(1);
  double largest = 0, off = 0;
  for (const std::vector<double>& row : table.rows) {
    if (!std::isfinite(row[a]) || !std::isfinite(row[b])) continue;
    largest = std::max(largest, std::abs(of_a * row[a]));
    off = std::max(off, std::abs(of_a * row[a] - of_b * row[b]));
  }
  return off <= kRounding * largest;
}

void TakeUnits(const std::vector<std::string_view>& cells, RawTable* table) {
  for (std::size_t c = 0; c < cells.size(); ++c) {
    RawColumn& column = table->columns[c];
    if (cells[c].empty() || column.to_si) continue;
    if (const auto unit = FindUnit(cells[c])) {
      column.to_si = unit->to_si;
      column.quantity = unit->quantity;
    } else {
      column.unknown_unit = cells[c];
    }
  }
}

void AddRow(const CsvLines& lines, RawTable* table) {
  const auto& cells = lines.cells();
  if (cells.size() != table->columns.size()) {
    lines.Fail(Formatted("%zu cells: expected %zu, the count of the header", cells.size(),
                         table->columns.size()));
  }
  std::vector<double> row;
  for (const std::string_view cell : cells) {
    row.push_back(ParseFinite(cell).value_or(std::numeric_limits<double>::quiet_NaN()));
  }
  table->rows.push_back(std::move(row));
  table->lines.push_back(lines.number());
}

}  // namespace

std::optional<std::size_t> RawTable::Find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names) {
    const auto found = std::ranges::find(columns, name, &RawColumn::name);
    if (found == columns.end()) continue;
    const auto first = static_cast<std::size_t>(found - columns.begin());
    for (std::size_t c = first + 1; c < columns.size(); ++c) {
      if (columns[c].name != name || IsSame(*this, first, c)) continue;
      throw InputError(
          Formatted("%s: the name %s occurs twice, as column %zu and column %zu, with other "
                    "numbers: expected "
                    "one specimen in a table; write each into a file of its own",
                    file.c_str(), Shown(columns[first].title).c_str(), first + 1, c + 1));
    }
    return first;
  }
  return std::nullopt;
}

std::size_t RawTable::Named(const std::string& title) const {
  auto found = std::ranges::find(columns, title, &RawColumn::title);
  if (found == columns.end()) found = std::ranges::find(columns, title, &RawColumn::name);
  if (found == columns.end()) {
    throw InputError(file.string() + ": no column " + Shown(title) + ": expected one of " +
                     Titles());
  }
  return static_cast<std::size_t>(found - columns.begin());
}

double RawTable::ToSi(std::size_t column, Quantity quantity, double without) const {
  const RawColumn& own = columns[column];
  if (!own.unknown_unit.empty() || (own.quantity && *own.quantity != quantity)) {
    throw InputError(Formatted("%s: column %s: expected %s", file.c_str(), Shown(own.title).c_str(),
                               InWords(quantity).c_str()));
  }
  return own.to_si.value_or(without);
}

double RawTable::At(std::size_t row, std::size_t column) const {
  const double value = rows[row][column];
  if (std::isfinite(value)) return value;
  CsvLines text(file);  // reads the file again, because rows contain only numbers
  while (text.Next() && text.number() < lines[row]) continue;
  const auto& cells = text.cells();
  const bool is_header = std::ranges::equal(cells, columns, {}, {}, &RawColumn::title);
  text.Fail(is_header ? "a second header: expected one test in a table; write each into a file of "
                        "its own"
                      : columns[column].title + " = " + Shown(std::string(cells[column])) +
                            ": expected a finite number");
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
    lines.DropEmptyEnd(table.columns.empty() ? 2 : table.columns.size());
    const auto& cells = lines.cells();
    if (table.rows.empty() && HasWord(cells) && IsRowOfUnits(cells, table.columns.size())) {
      TakeUnits(cells, &table);
    } else if (table.rows.size() <= kMaxRemarks && HasWord(cells)) {
      table.columns.clear();
      table.rows.clear();
      table.lines.clear();
      for (const std::string_view cell : cells) table.columns.push_back(ColumnOf(cell));
    } else if (!table.rows.empty() || IsRow(cells, table.columns.size())) {
      if (table.columns.empty()) {
        lines.Fail("numbers without a header: expected a line of column names above them");
      }
      AddRow(lines, &table);
    }
  }
  if (table.columns.empty())
    throw InputError(file.string() +
                     ": no header: expected a table between commas, semicolons or tabs");
  if (table.rows.empty()) throw InputError(file.string() + ": no row of numbers");
  return table;
}

}  // namespace palpate::identify
