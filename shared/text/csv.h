// Reads tables row by row: cells between commas, semicolons or tabs, quoted or not, decimal points
// or, where no comma separates, decimal commas; UTF-8 with or without mark, UTF-16, Latin-1. Errors
// have file and line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/text/column_title.h"
#include "shared/text/text.h"

namespace palpate {

// Appends `value` with `digits` significant digits (1 to 17; 17 round-trips) in any locale. Appends
// nothing if it is not finite, because an empty cell is an unknown number.
void AppendNumber(std::string* text, double value, int digits);

// Reads the cells of each line. Skips blank lines and lines that begin with `comment` (0: no
// comments).
class CsvLines {
 public:
  // Throws InputError `file: ...` if it cannot be read.
  explicit CsvLines(const std::filesystem::path& file, char comment = '#');

  // Reads the next line; false: there is none. Decimal commas become points. Throws InputError for
  // a line of 64 KiB or more, more than ten million lines, an unreadable file, an open quote, a
  // comma in a number where commas separate, decimal commas beside decimal points.
  bool Next();
  [[nodiscard]] const std::vector<std::string_view>& cells() const { return cells_; }
  [[nodiscard]] std::string_view text() const { return text_; }  // the line, trimmed
  [[nodiscard]] int number() const { return number_; }  // line number from 1; 0: before the first
  // Drops empty cells at the end, as spreadsheets write them, down to `count`.
  void DropEmptyEnd(std::size_t count);
  // Throws InputError `file:line: what` for the last line or for `line`.
  [[noreturn]] void Fail(const std::string& what, int line = 0) const;

 protected:
  [[nodiscard]] std::string Located(const std::string& what, int line = 0) const;

 private:
  // Reads one more block of the file as UTF-8. Returns false at its end.
  bool Fill();
  void Decode(std::string_view block);
  void ChooseDialect();
  void Split(std::string_view line, char separator);
  void TakeCommas();

  std::filesystem::path file_;
  std::ifstream stream_;
  enum class Encoding { kBytes, kUtf16Little, kUtf16Big } encoding_ = Encoding::kBytes;
  std::string odd_;     // bytes of UTF-16 whose character is not complete
  std::string buffer_;  // read, from `at_` on not yet used
  std::size_t at_ = 0;
  char line_end_ = '\n', separator_ = ',';
  std::string line_, unquoted_;
  std::string_view text_;
  char comment_;
  int number_ = 0;
  bool has_comma_ = false, has_point_ = false;  // decimal, in cells so far
  std::vector<std::string_view> cells_;
};

// Rows below a header whose columns are found by name. A unit in brackets behind a name, or in a
// row of units below the header, converts numbers to SI. Columns without a name are passed over.
class CsvTable : public CsvLines {
 public:
  struct Column {
    std::string_view name;
    bool required = true;
    std::optional<Quantity> quantity{};  // that its unit must be of; nullopt: any
  };
  // kOptional: a table that begins with a number has the known columns, in their order and all of
  // them; a header may have capital letters.
  enum class Header { kRequired, kOptional };
  // Reads the header. `columns`: those that are known, in any order, where lines of # are no
  // comments if a header is required; empty: any. Throws InputError if unreadable, empty, or with
  // an unknown, repeated or missing column, or a unit that is not understood or of another
  // quantity.
  explicit CsvTable(const std::filesystem::path& file, std::vector<Column> columns = {},
                    Header header = Header::kRequired);

  // Reads the next row; false: there is none. Throws InputError if the number of cells differs from
  // the header, or known columns have no row at all.
  bool Next();
  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  [[nodiscard]] std::optional<std::size_t> Find(std::string_view column) const;
  [[nodiscard]] bool Has(std::string_view column) const { return Find(column).has_value(); }
  // The column is absent, or its cell in this row is empty.
  [[nodiscard]] bool IsAbsent(std::string_view column) const;

  [[nodiscard]] std::string_view Text(std::size_t column) const { return cells()[column]; }
  // Throws InputError for an empty cell.
  [[nodiscard]] std::string Text(std::string_view column) const;
  [[nodiscard]] double to_si(std::size_t column) const { return to_si_[column]; }
  // Returns the number in SI. Throws InputError unless it is a finite number of magnitude `limit`
  // or less.
  [[nodiscard]] double Number(std::size_t column, double limit = 1e300) const;
  // 0 if an optional column or its cell is absent.
  [[nodiscard]] double Number(std::string_view column) const;
  // `file:line: column = cell: expected ...`; Refuse throws it.
  [[nodiscard]] std::string Complaint(std::size_t column, const std::string& accepted) const;
  [[noreturn]] void Refuse(std::size_t column, const std::string& accepted) const;
  [[noreturn]] void Refuse(std::string_view column, std::string_view accepted) const;

 private:
  void TakeHeader(Header header);
  // `unit`: unit given in a title or a cell for the column `name`.
  void RequireQuantity(std::string_view name, std::optional<Quantity> unit) const;
  bool IsRowOfUnits();

  std::vector<Column> columns_;
  std::vector<std::string> header_;
  std::vector<double> to_si_;  // per column
  bool is_empty_ = true;       // no row so far
  bool is_row_ = false;        // the line read last is a row that Next has not returned
};

}  // namespace palpate
