// A CSV file with a header, read as a whole, every complaint with its file and line.
#pragma once

#include <filesystem>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// `file:line: key = value: accepted is ...`
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class CsvTable {
 public:
  struct Column {
    std::string_view name;
    bool required = true;
  };

  // Columns may stand in any order; blank lines and carriage returns are skipped over. Throws
  // InputError: unreadable, empty, no rows, a column unknown, repeated or missing, a row with
  // another number of cells than the header.
  CsvTable(const std::filesystem::path& file, std::span<const Column> columns);

  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  [[nodiscard]] bool Has(std::string_view column) const;
  // Throws InputError for an empty cell.
  [[nodiscard]] const std::string& Text(std::size_t row, std::string_view column) const;
  // A finite number; 0 where an optional column or its cell is absent. Throws InputError.
  [[nodiscard]] double Number(std::size_t row, std::string_view column) const;
  // The error to throw for a cell's value.
  [[nodiscard]] InputError Refusal(std::size_t row, std::string_view column,
                                   std::string_view accepted) const;

 private:
  struct Row {
    int line = 0;
    std::vector<std::string> cells;
  };

  void ReadHeader(std::string_view line, int number, std::span<const Column> columns);
  [[nodiscard]] std::string At(int line) const;
  [[nodiscard]] const std::string* Find(std::size_t row, std::string_view column) const;

  std::filesystem::path file_;
  std::vector<std::string> header_;
  std::vector<std::string> optional_;  // columns
  std::vector<Row> rows_;
};

}  // namespace palpate
