// A text file of rows: fields between blanks or commas, comments from `#` to the end of the line,
// empty lines passed over, *INCLUDE lines replaced by the rows of the file they name.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "shared/mesh/files/file_cursor.h"

namespace palpate {

class RowReader : public SourcePlace {
 public:
  // Throws std::invalid_argument: a file cannot be read, files that include each other without end.
  explicit RowReader(const std::filesystem::path& file);

  // Goes to the next row; false: there is none.
  bool Next();
  // Goes to the next row, which must be there with `least` fields; `what` was expected.
  void Require(const char* what, std::size_t least);
  // Comes back to the present row with the next Next.
  void Back() { again_ = true; }

  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  std::int64_t Whole(std::size_t field, const char* what, std::int64_t low,
                     std::int64_t high) const;
  [[nodiscard]] double Real(std::size_t field, const char* what) const;
  [[nodiscard]] std::string Where() const override { return files_.back()->Where(); }

 private:
  void Include(const std::string& name);

  std::vector<std::unique_ptr<FileCursor>> files_;  // the last one is being read
  std::vector<std::string_view> fields_;
  bool again_ = false;
};

}  // namespace palpate
