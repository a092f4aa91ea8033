#include "slave/capture/csv_rows.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <system_error>

namespace palpate {
namespace {

constexpr std::size_t kLongestLine = 1 << 16;  // [bytes]
constexpr std::size_t kLongestQuote = 60;

std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

void Split(std::string_view line, std::vector<std::string_view>* cells) {
  cells->clear();
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells->push_back(Trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
}

// What people see of a cell: short, and nothing that moves their cursor.
std::string Quote(std::string_view cell) {
  std::string text(cell.substr(0, kLongestQuote));
  std::ranges::replace_if(
      text, [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
  return cell.size() > kLongestQuote ? text + "..." : text;
}

}  // namespace

std::optional<double> ParseCell(std::string_view cell) noexcept {
  if (cell.starts_with('+') && !cell.starts_with("+-")) cell.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  const bool is_whole = error == std::errc{} && end == cell.data() + cell.size();
  return is_whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

CsvRows::CsvRows(const std::filesystem::path& file)
    : file_(file), stream_(file, std::ios::binary), line_(kLongestLine) {
  std::error_code error;
  if (!stream_ || std::filesystem::is_directory(file, error)) {
    throw std::runtime_error(file.string() + ": cannot be read: accepted is a CSV file");
  }
  if (!ReadLine()) Fail("empty: accepted is a CSV file with a header row");
  if (text_.starts_with("\xEF\xBB\xBF")) text_.remove_prefix(3);
  Split(text_, &cells_);
  if (cells_.size() > 1 && cells_.back().empty()) cells_.pop_back();
  for (const std::string_view name : cells_) {
    if (Find(name)) Fail("column " + Quote(name) + " stands twice: accepted is once");
    header_.emplace_back(name);
  }
}

std::optional<std::size_t> CsvRows::Find(std::string_view column) const {
  const auto found = std::ranges::find(header_, column);
  if (found == header_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - header_.begin());
}

bool CsvRows::Next() {
  if (!ReadLine()) return false;
  Split(text_, &cells_);
  if (cells_.size() == header_.size() + 1 && cells_.back().empty()) cells_.pop_back();
  if (cells_.size() != header_.size()) {
    Fail(std::to_string(cells_.size()) + " columns: accepted is " + std::to_string(header_.size()) +
         ", as in the header");
  }
  return true;
}

bool CsvRows::ReadLine() {
  while (true) {
    stream_.getline(line_.data(), static_cast<std::streamsize>(line_.size()));
    auto length = static_cast<std::size_t>(stream_.gcount());
    if (length == 0 && stream_.eof()) return false;
    ++number_;
    if (stream_.bad()) Fail("cannot be read");
    if (stream_.fail()) Fail("a line of 64 KiB or more: accepted is a CSV file");
    if (!stream_.eof()) --length;  // the line's end counts, but is not stored
    text_ = Trimmed({line_.data(), length});
    if (!text_.empty() && !text_.starts_with('#')) return true;
  }
}

double CsvRows::Number(std::size_t column, double limit) const {
  const auto value = ParseCell(cells_[column]);
  if (!value || std::abs(*value) > limit) Refuse(column, "a finite number");
  return *value;
}

void CsvRows::Fail(const std::string& what) const {
  throw std::runtime_error(Located(what));
}

std::string CsvRows::Located(const std::string& what) const {
  return file_.string() + ":" + std::to_string(std::max(number_, 1)) + ": " + what;
}

std::string CsvRows::Complaint(std::size_t column, const std::string& accepted) const {
  return Located(Quote(header_[column]) + " = " + Quote(cells_[column]) + ": accepted is " +
                 accepted);
}

void CsvRows::Refuse(std::size_t column, const std::string& accepted) const {
  throw std::runtime_error(Complaint(column, accepted));
}

}  // namespace palpate
