#include "slave/mesh/files/file_cursor.h"

#include <charconv>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "shared/text/file_format.h"
#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr std::uintmax_t kMaxFile = 2ULL << 30U;  // [bytes]
constexpr std::size_t kMaxQuoteLength = 40;
constexpr std::string_view kBlanks = " \t\r\n\f\v";

template <class T>
bool Parses(std::string_view text, T* value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, *value);
  return error == std::errc() && stop == end;
}

std::string WholeNumber(std::int64_t low, std::int64_t high) {
  return "a whole number from " + std::to_string(low) + " to " + std::to_string(high);
}

constexpr std::string_view kBetween = " \t,\r\f\v";

std::vector<std::string_view> Split(std::string_view line) {
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> fields;
  for (std::size_t begin = line.find_first_not_of(kBetween); begin != std::string_view::npos;) {
    const std::size_t end = line.find_first_of(kBetween, begin);
    fields.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(kBetween, end);
  }
  return fields;
}

}  // namespace

void SourcePlace::Refuse(const std::string& what, const std::string& accepted) const {
  throw std::invalid_argument(Where() + ": " + what + ": expected " + accepted);
}

std::string Quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text.substr(0, kMaxQuoteLength)) quoted += c >= ' ' && c <= '~' ? c : '?';
  return quoted + (text.size() > kMaxQuoteLength ? "...'" : "'");
}

std::string Brief(double value) {
  return Formatted("%.4g", value);
}

std::int64_t ParseWhole(const SourcePlace& place, std::string_view text, const char* what,
                        std::int64_t low, std::int64_t high) {
  std::int64_t value = 0;
  if (!Parses(text, &value) || value < low || value > high) {
    place.Refuse(std::string(what) + " " + Quoted(text), WholeNumber(low, high));
  }
  return value;
}

double ParseReal(const SourcePlace& place, std::string_view text, const char* what) {
  double value = 0;
  if (!Parses(text, &value) || !std::isfinite(value)) {
    place.Refuse(std::string(what) + " " + Quoted(text), "a finite number");
  }
  return value;
}

FileCursor::FileCursor(std::filesystem::path file) : file_(std::move(file)) {
  try {
    text_ = ReadWholeFile(file_, kMaxFile, "a mesh file");
  } catch (const InputError& error) {
    throw std::invalid_argument(error.what());
  }
  if (const std::string foreign = ForeignFormat(std::string_view(text_)); !foreign.empty()) {
    throw std::invalid_argument(file_.string() + ": is " + foreign + ": expected a mesh file");
  }
  constexpr std::string_view kUtf8 = "\xEF\xBB\xBF", kUtf16Little = "\xFF\xFE",
                             kUtf16Big = "\xFE\xFF";
  if (text_.starts_with(kUtf16Little) || text_.starts_with(kUtf16Big)) {
    Refuse("text in UTF-16", "UTF-8");
  }
  if (text_.starts_with(kUtf8)) text_.erase(0, kUtf8.size());
  // Old programs end lines with CR only.
  const bool is_binary = text_.find('\0') != std::string::npos;
  if (!is_binary && text_.find('\n') == std::string::npos) std::ranges::replace(text_, '\r', '\n');
}

void FileCursor::Seek(std::size_t position) {
  position_ = std::min(position, text_.size());
}

std::string FileCursor::Where() const {
  if (form_ != NumberForm::kText) return file_.string() + ": byte " + std::to_string(mark_);
  const auto lines = std::ranges::count(text().substr(0, mark_), '\n');
  return file_.string() + ":" + std::to_string(lines + 1);
}

void FileCursor::RefuseEnd(const char* what) const {
  Refuse("the file ends", std::string(what) + " here");
}

void FileCursor::RefuseWhole(const char* what, const std::string& value, std::int64_t low,
                             std::int64_t high) const {
  Refuse(std::string(what) + " " + value, WholeNumber(low, high));
}

bool FileCursor::NextLine(std::string_view* line) {
  mark_ = position_;
  if (position_ >= text_.size()) return false;
  const std::size_t end = std::min(text().find('\n', position_), text_.size());
  *line = text().substr(position_, end - position_);
  if (line->ends_with('\r')) line->remove_suffix(1);
  position_ = std::min(end + 1, text_.size());
  return true;
}

std::string_view FileCursor::Word(const char* what) {
  const std::size_t begin = text().find_first_not_of(kBlanks, position_);
  mark_ = std::min(begin, text_.size());
  if (begin == std::string_view::npos) RefuseEnd(what);
  position_ = std::min(text().find_first_of(kBlanks, begin), text_.size());
  return text().substr(begin, position_ - begin);
}

bool FileCursor::AtEnd() const {
  return text().find_first_not_of(kBlanks, position_) == std::string_view::npos;
}

void FileCursor::RequireRoom(const char* what, std::size_t count, std::size_t bytes_each) const {
  const std::size_t room = rest().size() / bytes_each;
  if (count <= room) return;
  Refuse(std::string(what) + " " + std::to_string(count),
         "at most " + std::to_string(room) + ", what the rest of the file has room for");
}

bool MeshRowReader::Next() {
  std::string_view line;
  while (file_.NextLine(&line)) {
    fields_ = Split(line);
    if (!fields_.empty()) return true;
  }
  fields_.clear();
  return false;
}

void MeshRowReader::Require(const char* what, std::size_t least) {
  if (!Next()) Refuse("the file ends", std::string(what) + " here");
  if (fields_.size() < least) {
    Refuse(std::string(what) + " has " + std::to_string(fields_.size()) + " fields",
           std::to_string(least) + " or more");
  }
}

std::int64_t MeshRowReader::Whole(std::size_t field, const char* what, std::int64_t low,
                                  std::int64_t high) const {
  return ParseWhole(*this, fields_.at(field), what, low, high);
}

double MeshRowReader::Real(std::size_t field, const char* what) const {
  return ParseReal(*this, fields_.at(field), what);
}

}  // namespace palpate
