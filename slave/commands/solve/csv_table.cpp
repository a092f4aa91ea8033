#include "slave/commands/solve/csv_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

namespace palpate {
namespace {

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::vector<std::string> Split(std::string_view line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.emplace_back(Trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

std::string Names(std::span<const CsvTable::Column> columns) {
  std::string names;
  for (const auto& column : columns) {
    names += (names.empty() ? "" : ",") +
             (column.required ? std::string(column.name) : "[" + std::string(column.name) + "]");
  }
  return names;
}

}  // namespace

CsvTable::CsvTable(const std::filesystem::path& file, std::span<const Column> columns)
    : file_(file) {
  std::ifstream stream(file);
  if (!stream) throw InputError(file.string() + ": cannot be read");
  std::string line;
  int number = 0;
  while (std::getline(stream, line)) {
    ++number;
    std::string_view text = line;
    if (number == 1 && text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    text = Trimmed(text);
    if (text.empty()) continue;
    if (header_.empty()) {
      ReadHeader(text, number, columns);
      continue;
    }
    rows_.push_back({number, Split(text)});
    if (rows_.back().cells.size() != header_.size()) {
      throw InputError(At(number) + std::to_string(rows_.back().cells.size()) +
                       " cells: accepted is " + std::to_string(header_.size()) +
                       ", as in the header");
    }
  }
  if (stream.bad()) throw InputError(At(number + 1) + "cannot be read");
  if (rows_.empty()) {
    throw InputError(At(number + 1) + "no rows: accepted is a header " + Names(columns) +
                     " and one row or more");
  }
}

void CsvTable::ReadHeader(std::string_view line, int number, std::span<const Column> columns) {
  header_ = Split(line);
  for (auto name = header_.begin(); name != header_.end(); ++name) {
    const bool known = std::ranges::find(columns, *name, &Column::name) != columns.end();
    const bool repeated = std::find(header_.begin(), name, *name) != name;
    if (known && !repeated) continue;
    throw InputError(At(number) + "column = " + *name + (repeated ? " again" : "") +
                     ": accepted is " + Names(columns));
  }
  for (const auto& column : columns) {
    if (!column.required) optional_.emplace_back(column.name);
    if (!column.required || std::ranges::find(header_, column.name) != header_.end()) continue;
    throw InputError(At(number) + "no column " + std::string(column.name) + ": accepted is " +
                     Names(columns));
  }
}

std::string CsvTable::At(int line) const {
  return file_.string() + ":" + std::to_string(line) + ": ";
}

const std::string* CsvTable::Find(std::size_t row, std::string_view column) const {
  const auto name = std::ranges::find(header_, column);
  if (name == header_.end()) return nullptr;
  return &rows_[row].cells[static_cast<std::size_t>(name - header_.begin())];
}

bool CsvTable::Has(std::string_view column) const {
  return std::ranges::find(header_, column) != header_.end();
}

const std::string& CsvTable::Text(std::size_t row, std::string_view column) const {
  const std::string* cell = Find(row, column);
  if (cell == nullptr || cell->empty()) throw Refusal(row, column, "a name");
  return *cell;
}

double CsvTable::Number(std::size_t row, std::string_view column) const {
  const std::string* cell = Find(row, column);
  if (cell == nullptr) return 0;
  if (cell->empty() && std::ranges::find(optional_, column) != optional_.end()) return 0;
  const bool plus = cell->starts_with('+') && !cell->starts_with("+-");
  const char* begin = cell->data() + (plus ? 1 : 0);
  const char* end = cell->data() + cell->size();
  double value = 0;
  const auto [rest, error] = std::from_chars(begin, end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value)) {
    throw Refusal(row, column, "a finite number");
  }
  return value;
}

InputError CsvTable::Refusal(std::size_t row, std::string_view column,
                             std::string_view accepted) const {
  const std::string* cell = Find(row, column);
  return InputError(At(rows_[row].line) + std::string(column) + " = " + (cell ? *cell : "") +
                    ": accepted is " + std::string(accepted));
}

}  // namespace palpate
