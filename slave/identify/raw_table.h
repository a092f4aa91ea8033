// The numbers of a CSV table below any remarks, with its columns by name and unit.
#pragma once

#include <filesystem>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "shared/text/column_title.h"

namespace palpate::identify {

struct RawColumn : ColumnTitle {
  std::string title;  // unchanged text
};

struct RawTable {
  std::filesystem::path file;
  std::vector<RawColumn> columns;
  std::vector<std::vector<double>> rows;  // NaN: no number
  std::vector<int> lines;                 // of the rows in the file

  // The first column of one of these names, in the order of the names; nullopt: none. Throws
  // InputError: the name occurs twice with other numbers.
  [[nodiscard]] std::optional<std::size_t> Find(
      std::initializer_list<std::string_view> names) const;
  // The column with this title or name. Throws InputError naming those there are.
  [[nodiscard]] std::size_t Named(const std::string& title) const;
  [[nodiscard]] std::string Titles() const;
  // Returns a required cell. Throws InputError `file:line: ...`: it is no number.
  [[nodiscard]] double At(std::size_t row, std::size_t column) const;
  // Factor to SI of a column that holds `quantity`; `without`: that of a column without a unit.
  // Throws InputError naming the column: a unit of another quantity, or one that is not understood.
  [[nodiscard]] double ToSi(std::size_t column, Quantity quantity, double without) const;
};

// The header is the last line of words above a line with two numbers or more. Lines before it are
// remarks, and so are up to three lines of numbers above another header. Throws InputError
// `file:line: ...`: no header, no row, a row with more or fewer cells.
RawTable ReadRawTable(const std::filesystem::path& file);

}  // namespace palpate::identify
