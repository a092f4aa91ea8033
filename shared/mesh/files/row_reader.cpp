#include "shared/mesh/files/row_reader.h"

namespace palpate {
namespace {

constexpr std::size_t kDeepest = 8;  // files that include files
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

RowReader::RowReader(const std::filesystem::path& file) {
  files_.push_back(std::make_unique<FileCursor>(file));
}

void RowReader::Include(const std::string& name) {
  if (files_.size() >= kDeepest) {
    Refuse("*INCLUDE " + Quoted(name), std::to_string(kDeepest) + " files inside each other");
  }
  const std::filesystem::path file = files_.back()->file().parent_path() / name;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) {
    Refuse("*INCLUDE " + Quoted(name) + " cannot be read", "a file beside this one");
  }
  files_.push_back(std::make_unique<FileCursor>(file));
}

bool RowReader::Next() {
  if (again_) {
    again_ = false;
    return true;
  }
  std::string_view line;
  for (;;) {
    if (!files_.back()->NextLine(&line)) {
      fields_.clear();
      if (files_.size() == 1) return false;
      files_.pop_back();
      continue;
    }
    fields_ = Split(line);
    if (fields_.empty()) continue;
    if (fields_[0] != "*INCLUDE") return true;
    if (fields_.size() != 2) Refuse("*INCLUDE", "the name of a file after it");
    Include(std::string(fields_[1]));
  }
}

void RowReader::Require(const char* what, std::size_t least) {
  if (!Next()) Refuse("the file ends", std::string(what) + " here");
  if (fields_.size() < least) {
    Refuse(std::string(what) + " has " + std::to_string(fields_.size()) + " fields",
           std::to_string(least) + " or more");
  }
}

std::int64_t RowReader::Whole(std::size_t field, const char* what, std::int64_t low,
                              std::int64_t high) const {
  return ParseWhole(*this, fields_.at(field), what, low, high);
}

double RowReader::Real(std::size_t field, const char* what) const {
  return ParseReal(*this, fields_.at(field), what);
}

}  // namespace palpate
