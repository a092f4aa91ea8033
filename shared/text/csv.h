// CSV files, one row after the other, every complaint with its file and line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/text/text.h"

namespace palpate {

// Appends `value` with `digits` significant ones (1 to 17; 17 round-trips), the same in every
// locale; nothing if it is not finite: an empty cell is a number that is not known.
void AppendNumber(std::string* text, double value, int digits);

// The cells of each line, however many. Blank lines and lines that begin with `comment` are passed
// over (0: none are comments), as is a byte order mark.
class CsvLines {
 public:
  // Throws InputError `file: ...`: it cannot be read.
  explicit CsvLines(const std::filesystem::path& file, char comment = '#');

  // Goes to the next line; false: there is none. Throws InputError: a line of 64 KiB or more, more
  // than ten million lines, unreadable.
  bool Next();
  [[nodiscard]] const std::vector<std::string_view>& cells() const { return cells_; }
  [[nodiscard]] std::string_view text() const { return text_; }  // of the line, without blanks
  [[nodiscard]] int number() const { return number_; }  // of the line, from 1; 0: before it
  // Throws InputError `file:line: what`, of the line last read, or of another.
  [[noreturn]] void Fail(const std::string& what, int line = 0) const;

 protected:
  [[nodiscard]] std::string Located(const std::string& what, int line = 0) const;
  void DropLastCell() { cells_.pop_back(); }

 private:
  std::filesystem::path file_;
  std::ifstream stream_;
  std::vector<char> line_;
  std::string_view text_;
  char comment_;
  int number_ = 0;
  std::vector<std::string_view> cells_;
};

// Lines below one that names their columns.
class CsvBelowHeader : public CsvLines {
 public:
  using CsvLines::CsvLines;
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  [[nodiscard]] std::optional<std::size_t> Find(std::string_view column) const;

 protected:
  // Throws InputError: more or fewer cells than the header has.
  void RequireAllCells() const;
  std::vector<std::string> header_;
};

// Rows of columns to choose from. A comma at the end of a row, as some recorders write it, is none
// too many.
class CsvRows : public CsvBelowHeader {
 public:
  // Reads the header. Throws InputError: unreadable, empty, a column twice.
  explicit CsvRows(const std::filesystem::path& file);

  // Goes to the next row; false: there is none. Throws InputError, also for more or fewer cells
  // than the header has.
  bool Next();
  // Cells of this row, by column.
  [[nodiscard]] std::string_view Text(std::size_t column) const { return cells()[column]; }
  // Throws: not a finite number of at most `limit` in size.
  [[nodiscard]] double Number(std::size_t column, double limit) const;
  // `file:line: column = cell: accepted is ...`; Refuse throws it.
  [[nodiscard]] std::string Complaint(std::size_t column, const std::string& accepted) const;
  [[noreturn]] void Refuse(std::size_t column, const std::string& accepted) const;
};

// Rows of columns that are known beforehand, in any order.
class CsvTable : public CsvBelowHeader {
 public:
  struct Column {
    std::string_view name;
    bool required = true;
  };
  // Reads the header. Throws InputError: unreadable, empty, a column unknown, twice or missing.
  CsvTable(const std::filesystem::path& file, std::vector<Column> columns);

  // Goes to the next row; false: there is none. Throws InputError: no row at all, more or fewer
  // cells than the header.
  bool Next();
  [[nodiscard]] bool Has(std::string_view column) const { return Find(column).has_value(); }
  // Throws InputError for an empty cell.
  [[nodiscard]] std::string Text(std::string_view column) const;
  // A finite number; 0 where an optional column or its cell is absent. Throws InputError.
  [[nodiscard]] double Number(std::string_view column) const;
  [[noreturn]] void Refuse(std::string_view column, std::string_view accepted) const;

 private:
  std::vector<Column> columns_;
  bool is_empty_ = true;
};

}  // namespace palpate
