#include "shared/text/csv.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>
#include <utility>

#include "shared/text/column_title.h"
#include "shared/text/file_format.h"

namespace palpate {
namespace {

constexpr std::size_t kMaxLineLength = 1 << 16;  // [bytes]
constexpr int kMaxLines = 10'000'000;
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
// Typographic characters for blank, minus and square, with their ASCII equivalents.
constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kTypeset{
    {{"\u00A0", " "}, {"\u202F", " "}, {"\u2212", "-"}, {"\u00B2", "2"}}};
constexpr std::string_view kUtf16Little = "\xFF\xFE", kUtf16Big = "\xFE\xFF";

void AppendUtf8(unsigned code, std::string* text) {
  const auto byte = [&](unsigned value) { *text += static_cast<char>(value); };
  if (code < 0x80) return byte(code);
  if (code < 0x800) {
    byte(0xC0U | code >> 6U);
  } else if (code < 0x10000) {
    byte(0xE0U | code >> 12U), byte(0x80U | (code >> 6U & 0x3FU));
  } else {
    byte(0xF0U | code >> 18U), byte(0x80U | (code >> 12U & 0x3FU));
    byte(0x80U | (code >> 6U & 0x3FU));
  }
  byte(0x80U | (code & 0x3FU));
}

// Converts a decimal comma to a point; nullopt: the cell is no such number.
std::optional<std::string> WithPoint(std::string_view cell) {
  const std::size_t comma = cell.find(',');
  if (comma == std::string_view::npos) return std::nullopt;
  std::string point(cell);
  point[comma] = '.';
  return ParseFinite(point) ? std::optional(point) : std::nullopt;
}

// Returns the expected range for a number beyond `limit`. Since 1970 1e18 to 1e19 ns have passed by
// 2001 to 2286.
std::string InRange(double value, double limit) {
  std::string words = Formatted("a finite number up to %.3g", limit);
  if (value >= 1e18 && value < 1e19) {
    words += ". As a time, these are nanoseconds since 1970: name their unit, as in t (ns)";
  }
  return words;
}

std::string Names(std::span<const CsvTable::Column> columns) {
  std::string names;
  for (const auto& [name, required, quantity] : columns) {
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
    : file_(file), stream_(file, std::ios::binary), comment_(comment) {
  std::error_code error;
  if (!stream_ || std::filesystem::is_directory(file, error)) {
    throw InputError(file.string() + ": cannot be read: expected a CSV file");
  }
  Fill();
  if (const std::string foreign = ForeignFormat(std::string_view(buffer_)); !foreign.empty()) {
    throw InputError(file.string() + ": is " + foreign + ": expected a CSV file");
  }
  const std::string_view text = Trimmed(buffer_);  // a scene may be JSON, which is YAML
  if (text.starts_with("{") || text.starts_with("[{") || text.starts_with("[[")) {
    throw InputError(file.string() + ": is JSON: save the table as CSV: expected a CSV file");
  }
  ChooseDialect();
}

bool CsvLines::Fill() {
  std::string block(kMaxLineLength, '\0');
  const bool is_first = at_ == 0 && buffer_.empty() && odd_.empty();
  stream_.read(block.data(), static_cast<std::streamsize>(block.size()));
  block.resize(static_cast<std::size_t>(stream_.gcount()));
  if (stream_.bad()) Fail("cannot be read");
  if (block.empty()) return false;
  buffer_.erase(0, at_);
  at_ = 0;
  std::string_view rest = block;
  if (is_first && rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
  if (is_first && (rest.starts_with(kUtf16Little) || rest.starts_with(kUtf16Big))) {
    encoding_ = rest.starts_with(kUtf16Big) ? Encoding::kUtf16Big : Encoding::kUtf16Little;
    rest.remove_prefix(kUtf16Little.size());
  }
  Decode(rest);
  return true;
}

void CsvLines::Decode(std::string_view block) {
  if (encoding_ == Encoding::kBytes) {
    buffer_.append(block);
    return;
  }
  odd_.append(block);
  const auto unit = [&](std::size_t i) {
    const auto first = static_cast<unsigned char>(odd_[i]);
    const auto second = static_cast<unsigned char>(odd_[i + 1]);
    return encoding_ == Encoding::kUtf16Big ? first << 8U | second : second << 8U | first;
  };
  std::size_t i = 0;
  while (i + 1 < odd_.size()) {
    unsigned code = static_cast<unsigned>(unit(i));
    if ((code & 0xFC00U) == 0xD800U) {  // the first half of a pair
      if (i + 3 >= odd_.size()) break;
      code = 0x10000U + ((code & 0x3FFU) << 10U) + (static_cast<unsigned>(unit(i + 2)) & 0x3FFU);
      i += 2;
    }
    AppendUtf8(code, &buffer_);
    i += 2;
  }
  odd_.erase(0, i);
}

// Chooses the separator that yields most numbers; without numbers, one that occurs. The comma is
// tried last, because it may be part of names and numbers.
void CsvLines::ChooseDialect() {
  const std::string_view head = buffer_;
  if (head.find('\n') == std::string_view::npos) line_end_ = '\r';
  std::size_t most = 0, max_cells = 0;
  for (const char separator : {'\t', ';', ','}) {
    std::size_t numbers = 0, cells = 0;
    for (std::size_t begin = 0; begin < head.size();) {
      const std::size_t end = std::min(head.find(line_end_, begin), head.size());
      const std::string_view line = Trimmed(head.substr(begin, end - begin));
      begin = end + 1;
      if (line.empty() || (comment_ != 0 && line.front() == comment_)) continue;
      if (end == head.size() && end >= kMaxLineLength) continue;  // the line may be incomplete
      try {
        Split(line, separator);
      } catch (const InputError&) {
        continue;
      }
      if (cells_.size() < 2) continue;
      cells += cells_.size();
      for (const std::string_view cell : cells_) {
        const bool is_number = ParseFinite(cell) || (separator != ',' && WithPoint(cell));
        numbers += is_number ? 1 : 0;
      }
    }
    // For a header without numbers the number of names decides. For 0,5;2,5 comma and semicolon
    // yield equally many numbers.
    const bool is_better = numbers > most || (numbers == 0 && most == 0 && cells > max_cells);
    if (!is_better) continue;
    most = numbers;
    max_cells = cells;
    separator_ = separator;
  }
  cells_.clear();
}

// Splits into cells. Separators inside of quotes do not split; two quotes inside of quotes are one.
void CsvLines::Split(std::string_view line, char separator) {
  cells_.clear();
  unquoted_.clear();
  unquoted_.reserve(line.size());  // cells stay where they are
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t first = line.find_first_not_of(' ', begin);
    if (first == std::string_view::npos || line[first] != '"') {
      const std::size_t end = std::min(line.find(separator, begin), line.size());
      cells_.push_back(Trimmed(line.substr(begin, end - begin)));
      begin = end + 1;
      continue;
    }
    const std::size_t from = unquoted_.size();
    std::size_t at = first + 1;
    bool is_closed = false;
    while (at < line.size() && !is_closed) {
      if (line[at] != '"') {
        unquoted_ += line[at++];
      } else if (at + 1 < line.size() && line[at + 1] == '"') {
        unquoted_ += '"';
        at += 2;
      } else {
        is_closed = true;
        ++at;
      }
    }
    const std::size_t end = std::min(line.find_first_not_of(' ', at), line.size());
    if (!is_closed || (end < line.size() && line[end] != separator)) {
      Fail("a quote that is not closed, or text behind it: expected \"...\" around a cell");
    }
    cells_.push_back(Trimmed(std::string_view(unquoted_).substr(from)));
    begin = end + 1;
  }
}

// A decimal comma becomes a point.
void CsvLines::TakeCommas() {
  const auto refuse_mixed = [&](std::string_view cell) {
    if (has_comma_ && has_point_) {
      Fail(Shown(cell) + ": decimal commas and decimal points in one table: expected one of them");
    }
  };
  for (std::string_view& cell : cells_) {
    if (cell.find('.') != std::string_view::npos && separator_ != ',' && ParseFinite(cell)) {
      has_point_ = true;
      refuse_mixed(cell);
    }
    const auto point = WithPoint(cell);
    if (!point) continue;
    if (separator_ == ',') {
      Fail(Shown(cell) + ": a comma in a number: expected a decimal point where commas separate");
    }
    has_comma_ = true;
    refuse_mixed(cell);
    // Replaces the comma in place, in either of the two buffers.
    *const_cast<char*>(cell.data() + cell.find(',')) = '.';
  }
}

bool CsvLines::Next() {
  do {
    std::size_t end = buffer_.find(line_end_, at_);
    while (end == std::string::npos && buffer_.size() - at_ < kMaxLineLength && Fill()) {
      end = buffer_.find(line_end_, at_);
    }
    if (at_ >= buffer_.size()) return false;
    ++number_;
    const std::size_t length = std::min(end, buffer_.size()) - at_;
    if (length + 1 >= kMaxLineLength) Fail("a line of 64 KiB or more: expected a CSV file");
    if (number_ > kMaxLines) Fail("more than ten million lines: expected a shorter file");
    const std::string_view raw = std::string_view(buffer_).substr(at_, length);
    line_.clear();
    if (FindInvalidUtf8(raw) == std::string_view::npos) {
      line_ = raw;
    } else {  // Latin-1
      for (const char c : raw) AppendUtf8(static_cast<unsigned char>(c), &line_);
    }
    at_ = std::min(at_ + length + 1, buffer_.size());
    for (const auto& [typeset, plain] : kTypeset) {
      for (std::size_t i = 0; (i = line_.find(typeset, i)) != std::string::npos;) {
        line_.replace(i, typeset.size(), plain);
      }
    }
    text_ = Trimmed(line_);
  } while (text_.empty() || (comment_ != 0 && text_.front() == comment_));
  // A tab at the line's beginning is behind an empty cell.
  Split(separator_ == '\t' ? std::string_view(line_).substr(0, line_.find_last_not_of('\r') + 1)
                           : text_,
        separator_);
  TakeCommas();
  return true;
}

void CsvLines::DropEmptyEnd(std::size_t count) {
  while (cells_.size() > count && cells_.back().empty()) cells_.pop_back();
}

void CsvLines::Fail(const std::string& what, int line) const {
  throw InputError(Located(what, line));
}

std::string CsvLines::Located(const std::string& what, int line) const {
  const int number = std::max(line > 0 ? line : number_, 1);
  return file_.string() + ":" + std::to_string(number) + ": " + what;
}

CsvTable::CsvTable(const std::filesystem::path& file, std::vector<Column> columns, Header header)
    : CsvLines(file, columns.empty() || header == Header::kOptional ? '#' : 0),
      columns_(std::move(columns)) {
  if (CsvLines::Next()) {
    TakeHeader(header);
  } else if (columns_.empty()) {
    Fail("empty: expected a CSV file with a header row");
  }  // otherwise Next reports the error
}

void CsvTable::TakeHeader(Header header) {
  DropEmptyEnd(1);
  const auto is_number = [](std::string_view cell) { return ParseFinite(cell).has_value(); };
  if (header == Header::kOptional && std::ranges::any_of(cells(), is_number)) {
    is_row_ = true;
    for (const Column& column : columns_) header_.emplace_back(column.name);
    to_si_.assign(header_.size(), 1);
    return;
  }
  std::string refused;  // message about an unknown column
  for (const std::string_view title : cells()) {
    const bool is_known = std::ranges::find(columns_, title, &Column::name) != columns_.end();
    const bool is_free = header == Header::kOptional;
    const ColumnTitle parts = is_known  ? ColumnTitle{std::string(title)}
                              : is_free ? SplitFreeTitle(title)
                                        : SplitTitle(title);
    if (!parts.unknown_unit.empty() && !columns_.empty()) {
      Fail("column " + Shown(title) + ": unit " + Shown(parts.unknown_unit) +
           " is not understood: expected " + InWords(Quantity::kLength) + ", " +
           InWords(Quantity::kForce) + " or " + InWords(Quantity::kTime));
    }
    const std::string name = parts.to_si || is_free ? parts.name : std::string(title);
    const bool is_repeated = !name.empty() && Find(name);
    if (is_repeated && columns_.empty()) {
      Fail("column " + Shown(name) + " appears twice: expected " +
           (ParseFinite(name) ? "a header row above the numbers" : "once"));
    }
    const bool is_wanted = columns_.empty() || name.empty() ||
                           std::ranges::find(columns_, name, &Column::name) != columns_.end();
    if ((is_repeated || !is_wanted) && refused.empty()) {
      refused = "column = " + Shown(title) + CodesIn(title) + (is_repeated ? " again" : "") +
                ": expected " + Names(columns_);
    }
    if (!refused.empty() && !is_free) Fail(refused);
    RequireQuantity(name, parts.quantity);
    header_.push_back(name);
    to_si_.push_back(parts.to_si.value_or(1));
  }
  for (const Column& column : columns_) {
    if (!column.required || Has(column.name)) continue;
    Fail("no column " + std::string(column.name) + ": expected " + Names(columns_));
  }
  // The message about an unknown column comes after that about missing columns, which does not
  // quote the file.
  if (!refused.empty()) Fail(refused);
}

void CsvTable::RequireQuantity(std::string_view name, std::optional<Quantity> unit) const {
  const auto known = std::ranges::find(columns_, name, &Column::name);
  if (known == columns_.end() || !known->quantity || !unit || *unit == *known->quantity) return;
  Fail("column " + Shown(name) + ": a unit of another quantity: expected " +
       InWords(*known->quantity));
}

// Returns whether this is a row of units: at least one unit and no number. If so, applies the
// units.
bool CsvTable::IsRowOfUnits() {
  bool has_unit = false;
  std::vector<double> to_si = to_si_;
  for (std::size_t i = 0; i < cells().size(); ++i) {
    if (cells()[i].empty()) continue;
    const auto unit = FindUnit(cells()[i]);
    if (!unit) return false;
    has_unit = has_unit || (!ParseFinite(cells()[i]) && unit->name != "-");
    RequireQuantity(header_[i], unit->quantity);
    to_si[i] = unit->to_si;
  }
  if (has_unit) to_si_ = std::move(to_si);
  return has_unit;
}

bool CsvTable::Next() {
  if (!std::exchange(is_row_, false) && !CsvLines::Next()) {
    if (!is_empty_ || columns_.empty()) return false;
    Fail("no rows: expected a header " + Names(columns_) + " and one row or more", number() + 1);
  }
  DropEmptyEnd(header_.size());
  if (cells().size() != header_.size()) {
    Fail(std::to_string(cells().size()) + " cells: expected " + std::to_string(header_.size()) +
         ", as in the header");
  }
  if (is_empty_ && IsRowOfUnits()) return Next();
  is_empty_ = false;
  return true;
}

std::optional<std::size_t> CsvTable::Find(std::string_view column) const {
  const auto found = std::ranges::find(header_, column);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

bool CsvTable::IsAbsent(std::string_view column) const {
  const auto place = Find(column);
  return !place || cells()[*place].empty();
}

std::string CsvTable::Text(std::string_view column) const {
  if (IsAbsent(column)) Refuse(column, "a name");
  return std::string(cells()[*Find(column)]);
}

double CsvTable::Number(std::size_t column, double limit) const {
  const auto value = ParseFinite(Text(column));
  if (!value) Refuse(column, "a finite number");
  const double si = to_si_[column] * *value;
  if (!(std::abs(si) <= limit)) Refuse(column, InRange(*value, limit));
  return si;
}

double CsvTable::Number(std::string_view column) const {
  const auto place = Find(column);
  if (!place) return 0;
  const auto known = std::ranges::find(columns_, column, &Column::name);
  if (cells()[*place].empty() && known != columns_.end() && !known->required) return 0;
  return Number(*place);
}

std::string CsvTable::Complaint(std::size_t column, const std::string& accepted) const {
  return Located(Shown(header_[column]) + " = " + Shown(Text(column)) + ": expected " + accepted);
}

void CsvTable::Refuse(std::size_t column, const std::string& accepted) const {
  throw InputError(Complaint(column, accepted));
}

void CsvTable::Refuse(std::string_view column, std::string_view accepted) const {
  if (const auto place = Find(column)) Refuse(*place, std::string(accepted));
  Fail(std::string(column) + " = : expected " + std::string(accepted));
}

}  // namespace palpate
