// Rows of a CSV file with a header, one after the other, every complaint with its file and line.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

// A number as recordings write it, in every locale: `12`, `-0.5`, `+3e4`. nullopt: none, or not
// finite.
std::optional<double> ParseCell(std::string_view cell) noexcept;

// Blank lines and lines that begin with # are passed over; a comma at the end of a row, as some
// recorders write it, is none too many.
class CsvRows {
 public:
  // Reads the header. Throws std::runtime_error `file:line: ...`: unreadable, empty, a column
  // twice.
  explicit CsvRows(const std::filesystem::path& file);

  [[nodiscard]] const std::vector<std::string>& header() const { return header_; }
  [[nodiscard]] std::optional<std::size_t> Find(std::string_view column) const;
  // Goes to the next row; false: there is none. Throws: more or fewer cells than the header, a line
  // of 64 KiB or more, unreadable.
  bool Next();
  // Cells of this row, by column.
  [[nodiscard]] std::string_view Text(std::size_t column) const { return cells_[column]; }
  // Throws: not a finite number of at most `limit` in size.
  [[nodiscard]] double Number(std::size_t column, double limit) const;
  // Throws std::runtime_error `file:line: what`, of the line last read.
  [[noreturn]] void Fail(const std::string& what) const;
  // `file:line: column = cell: accepted is ...`; Refuse throws it.
  [[nodiscard]] std::string Complaint(std::size_t column, const std::string& accepted) const;
  [[noreturn]] void Refuse(std::size_t column, const std::string& accepted) const;

 private:
  bool ReadLine();
  [[nodiscard]] std::string Located(const std::string& what) const;

  std::filesystem::path file_;
  std::ifstream stream_;
  std::vector<char> line_;
  std::string_view text_;  // of the line last read
  int number_ = 0;         // of that line, from 1
  std::vector<std::string> header_;
  std::vector<std::string_view> cells_;
};

}  // namespace palpate
