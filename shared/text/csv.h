// Reads CSV files row by row. Errors have file and line.
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

// Appends `value` with `digits` significant digits (1 to 17; 17 round-trips) in any locale. Appends
// nothing if it is not finite, because an empty cell is an unknown number.
void AppendNumber(std::string* text, double value, int digits);

// Reads the cells of each line. Skips blank lines, lines that begin with `comment` (0: no comments)
// and a byte order mark.
class CsvLines {
 public:
  // Throws InputError `file: ...` if it cannot be read.
  explicit CsvLines(const std::filesystem::path& file, char comment = '#');

  // Reads the next line; false: there is none. Throws InputError for a line of 64 KiB or more, more
  // than ten million lines, or an unreadable file.
  bool Next();
  [[nodiscard]] const std::vector<std::string_view>& cells() const { return cells_; }
  [[nodiscard]] std::string_view text() const { return text_; }  // the line, trimmed
  [[nodiscard]] int number() const { return number_; }  // line number from 1; 0: before the first
  // Throws InputError `file:line: what` for the last line or for `line`.
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

// Lines below a header.
class CsvBelowHeader : public CsvLines {
 public:
  using CsvLines::CsvLines;
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  [[nodiscard]] std::optional<std::size_t> Find(std::string_view column) const;

 protected:
  // Throws InputError if the number of cells differs from the header.
  void RequireAllCells() const;
  std::vector<std::string> header_;
};

// Rows with arbitrary columns. A comma at the end of a row is accepted.
class CsvRows : public CsvBelowHeader {
 public:
  // Reads the header. Throws InputError if unreadable, empty, or with a repeated column.
  explicit CsvRows(const std::filesystem::path& file);

  // Reads the next row; false: there is none. Throws InputError, also if the number of cells
  // differs from the header.
  bool Next();
  // Cells of this row, by column.
  [[nodiscard]] std::string_view Text(std::size_t column) const { return cells()[column]; }
  // Throws unless the cell is a finite number of magnitude `limit` or less.
  [[nodiscard]] double Number(std::size_t column, double limit) const;
  // `file:line: column = cell: accepted is ...`; Refuse throws it.
  [[nodiscard]] std::string Complaint(std::size_t column, const std::string& accepted) const;
  [[noreturn]] void Refuse(std::size_t column, const std::string& accepted) const;
};

// Rows with known columns, in any order.
class CsvTable : public CsvBelowHeader {
 public:
  struct Column {
    std::string_view name;
    bool required = true;
  };
  // Reads the header. Throws InputError if unreadable, empty, or with an unknown, repeated or
  // missing column.
  CsvTable(const std::filesystem::path& file, std::vector<Column> columns);

  // Reads the next row; false: there is none. Throws InputError if there is no row at all, or the
  // number of cells differs from the header.
  bool Next();
  [[nodiscard]] bool Has(std::string_view column) const { return Find(column).has_value(); }
  // The column is absent, or its cell in this row is empty.
  [[nodiscard]] bool IsAbsent(std::string_view column) const;
  // Throws InputError for an empty cell.
  [[nodiscard]] std::string Text(std::string_view column) const;
  // A finite number; 0 if an optional column or its cell is absent. Throws InputError.
  [[nodiscard]] double Number(std::string_view column) const;
  [[noreturn]] void Refuse(std::string_view column, std::string_view accepted) const;

 private:
  std::vector<Column> columns_;
  bool is_empty_ = true;
};

}  // namespace palpate
