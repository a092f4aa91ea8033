#include "shared/text/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

namespace palpate {
namespace {

constexpr std::size_t kLongestLine = 1 << 16;  // [bytes]
constexpr int kMostLines = 10'000'000;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

void Split(std::string_view line, std::vector<std::string_view>* cells) {
  cells->clear();
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells->push_back(Trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
}

std::string Names(std::span<const CsvTable::Column> columns) {
  std::string names;
  for (const auto& [name, required] : columns) {
    names.append(names.empty() ? "" : ",").append(required ? "" : "[");
    names.append(name).append(required ? "" : "]");
  }
  return names;
}

}  // namespace

void AppendNumber(std::string* text, double value, int digits) {
  if (!std::isfinite(value)) return;
  std::array<char, 32> buffer{};
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                          value == 0 ? 0 : value,  // no "-0"
                                          std::chars_format::general, digits);
  text->append(buffer.data(), end);
}

CsvLines::CsvLines(const std::filesystem::path& file, char comment)
    : file_(file), stream_(file, std::ios::binary), line_(kLongestLine), comment_(comment) {
  std::error_code error;
  if (!stream_ || std::filesystem::is_directory(file, error)) {
    throw InputError(file.string() + ": cannot be read: accepted is a CSV file");
  }
}

bool CsvLines::Next() {
  do {
    stream_.getline(line_.data(), static_cast<std::streamsize>(line_.size()));
    auto length = static_cast<std::size_t>(stream_.gcount());
    if (length == 0 && stream_.eof()) return false;
    ++number_;
    if (stream_.bad()) Fail("cannot be read");
    if (stream_.fail()) Fail("a line of 64 KiB or more: accepted is a CSV file");
    if (number_ > kMostLines) Fail("more than ten million lines: accepted is a shorter file");
    if (!stream_.eof()) --length;  // the line's end counts, but is not stored
    text_ = {line_.data(), length};
    if (number_ == 1 && text_.starts_with(kByteOrderMark)) {
      text_.remove_prefix(kByteOrderMark.size());
    }
    text_ = Trimmed(text_);
  } while (text_.empty() || (comment_ != 0 && text_.front() == comment_));
  Split(text_, &cells_);
  return true;
}

void CsvLines::Fail(const std::string& what, int line) const {
  throw InputError(Located(what, line));
}

std::string CsvLines::Located(const std::string& what, int line) const {
  const int number = std::max(line > 0 ? line : number_, 1);
  return file_.string() + ":" + std::to_string(number) + ": " + what;
}

std::optional<std::size_t> CsvBelowHeader::Find(std::string_view column) const {
  const auto found = std::ranges::find(header_, column);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

void CsvBelowHeader::RequireAllCells() const {
  if (cells().size() == header_.size()) return;
  Fail(std::to_string(cells().size()) + " cells: accepted is " + std::to_string(header_.size()) +
       ", as in the header");
}

CsvRows::CsvRows(const std::filesystem::path& file) : CsvBelowHeader(file) {
  if (!CsvLines::Next()) Fail("empty: accepted is a CSV file with a header row");
  if (cells().size() > 1 && cells().back().empty()) DropLastCell();
  for (const std::string_view name : cells()) {
    if (Find(name)) Fail("column " + Shown(name) + " appears twice: accepted is once");
    header_.emplace_back(name);
  }
}

bool CsvRows::Next() {
  if (!CsvLines::Next()) return false;
  if (cells().size() == header_.size() + 1 && cells().back().empty()) DropLastCell();
  RequireAllCells();
  return true;
}

double CsvRows::Number(std::size_t column, double limit) const {
  const auto value = ParseFinite(Text(column));
  if (!value || std::abs(*value) > limit) Refuse(column, "a finite number");
  return *value;
}

std::string CsvRows::Complaint(std::size_t column, const std::string& accepted) const {
  return Located(Shown(header_[column]) + " = " + Shown(Text(column)) + ": accepted is " +
                 accepted);
}

void CsvRows::Refuse(std::size_t column, const std::string& accepted) const {
  throw InputError(Complaint(column, accepted));
}

CsvTable::CsvTable(const std::filesystem::path& file, std::vector<Column> columns)
    : CsvBelowHeader(file, 0), columns_(std::move(columns)) {
  if (!CsvLines::Next()) return;  // Next complains
  for (const std::string_view name : cells()) {
    const bool is_repeated = std::ranges::find(header_, name) != header_.end();
    header_.emplace_back(name);
    if (!is_repeated && std::ranges::find(columns_, name, &Column::name) != columns_.end())
      continue;
    Fail("column = " + Shown(name) + (is_repeated ? " again" : "") + ": accepted is " +
         Names(columns_));
  }
  for (const auto& [name, required] : columns_) {
    if (!required || Has(name)) continue;
    Fail("no column " + std::string(name) + ": accepted is " + Names(columns_));
  }
}

bool CsvTable::Next() {
  if (CsvLines::Next()) {
    RequireAllCells();
    is_empty_ = false;
    return true;
  }
  if (!is_empty_) return false;
  Fail("no rows: accepted is a header " + Names(columns_) + " and one row or more", number() + 1);
}

std::string CsvTable::Text(std::string_view column) const {
  const auto place = Find(column);
  if (!place || cells()[*place].empty()) Refuse(column, "a name");
  return std::string(cells()[*place]);
}

bool CsvTable::IsAbsent(std::string_view column) const {
  const auto place = Find(column);
  return !place || cells()[*place].empty();
}

double CsvTable::Number(std::string_view column) const {
  const auto place = Find(column);
  if (!place) return 0;
  const std::string_view cell = cells()[*place];
  if (cell.empty() && !std::ranges::find(columns_, column, &Column::name)->required) return 0;
  const auto value = ParseFinite(cell);
  if (!value) Refuse(column, "a finite number");
  return *value;
}

void CsvTable::Refuse(std::string_view column, std::string_view accepted) const {
  const auto place = Find(column);
  Fail(std::string(column) + " = " + (place ? Shown(cells()[*place]) : "") + ": accepted is " +
       std::string(accepted));
}

}  // namespace palpate
