// A mesh file in memory with a read position for words, lines and raw numbers.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace palpate {

// Position of a reader, for error messages.
class SourcePlace {
 public:
  virtual ~SourcePlace() = default;
  // Throws std::invalid_argument, `where: what: expected accepted`.
  [[noreturn]] void Refuse(const std::string& what, const std::string& accepted) const;
  // `file:line`, or `file: byte n` among binary numbers.
  [[nodiscard]] virtual std::string Where() const = 0;
};

// Returns `text` in quotes, shortened, with question marks for unprintable characters.
std::string Quoted(std::string_view text);
// Returns a number in few digits.
std::string Brief(double value);
// Parse the whole text as a number in the C locale; errors are thrown by `place`.
std::int64_t ParseWhole(const SourcePlace& place, std::string_view text, const char* what,
                        std::int64_t low, std::int64_t high);
double ParseReal(const SourcePlace& place, std::string_view text, const char* what);

// How the numbers of a file are written.
enum class NumberForm : std::uint8_t { kText, kLittleEndian, kBigEndian };

class FileCursor : public SourcePlace {
 public:
  // Reads the whole file. Throws std::invalid_argument: it cannot be read or is larger than 2 GiB.
  explicit FileCursor(std::filesystem::path file);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] std::string_view text() const { return text_; }
  [[nodiscard]] std::string_view rest() const { return text().substr(position_); }
  [[nodiscard]] std::size_t position() const { return position_; }
  void Seek(std::size_t position);
  void set_form(NumberForm form) { form_ = form; }
  [[nodiscard]] NumberForm form() const { return form_; }

  [[nodiscard]] std::string Where() const override;

  // The rest of the line, without its end. False: end of the file.
  bool NextLine(std::string_view* line);
  // Returns the next word. Throws at the file's end; `what` is the expected item.
  std::string_view Word(const char* what);
  // Returns whether only blanks are left.
  [[nodiscard]] bool AtEnd() const;

  // Reads the next number as type T, as text or bytes. Throws if none is left or it is outside
  // [low, high].
  template <std::integral T>
  std::int64_t Whole(const char* what, std::int64_t low, std::int64_t high) {
    if (form_ == NumberForm::kText) return ParseWhole(*this, Word(what), what, low, high);
    const T value = Raw<T>(what);
    if (std::in_range<std::int64_t>(value)) {
      const auto whole = static_cast<std::int64_t>(value);
      if (whole >= low && whole <= high) return whole;
    }
    RefuseWhole(what, std::to_string(value), low, high);
  }
  // Reads a finite number. Throws if none is left or it is not finite.
  template <std::floating_point T>
  double Real(const char* what) {
    if (form_ == NumberForm::kText) return ParseReal(*this, Word(what), what);
    const auto value = static_cast<double>(Raw<T>(what));
    if (!std::isfinite(value)) Refuse(std::string(what) + " is not finite", "a finite number");
    return value;
  }
  // x, y, z.
  template <std::floating_point T>
  Eigen::Vector3d Point() {
    const double x = Real<T>("x"), y = Real<T>("y");
    return {x, y, Real<T>("z")};
  }
  // Reads a number of items of at least `bytes_each` bytes, so that the rest of the file must be
  // long enough.
  template <std::integral T>
  std::size_t Count(const char* what, std::size_t bytes_each) {
    const std::int64_t count = Whole<T>(what, 0, kMaxCount);
    RequireRoom(what, static_cast<std::size_t>(count), bytes_each);
    return static_cast<std::size_t>(count);
  }
  void RequireRoom(const char* what, std::size_t count, std::size_t bytes_each) const;

  static constexpr std::int64_t kMaxCount = 2'000'000'000;  // of anything; an int holds it

 private:
  template <class T>
  T Raw(const char* what) {
    mark_ = position_;
    std::array<char, sizeof(T)> bytes{};
    if (rest().size() < bytes.size()) RefuseEnd(what);
    std::memcpy(bytes.data(), rest().data(), bytes.size());
    const bool little = form_ == NumberForm::kLittleEndian;
    if (little != (std::endian::native == std::endian::little)) std::ranges::reverse(bytes);
    position_ += bytes.size();
    return std::bit_cast<T>(bytes);
  }
  [[noreturn]] void RefuseEnd(const char* what) const;
  [[noreturn]] void RefuseWhole(const char* what, const std::string& value, std::int64_t low,
                                std::int64_t high) const;

  std::filesystem::path file_;
  std::string text_;
  std::size_t position_ = 0;
  std::size_t mark_ = 0;  // start of the last read item
  NumberForm form_ = NumberForm::kText;
};

// A text file of rows: fields between blanks or commas, comments from `#` to the end of the line,
// empty lines are skipped.
class MeshRowReader : public SourcePlace {
 public:
  // Throws std::invalid_argument: the file cannot be read.
  explicit MeshRowReader(const std::filesystem::path& file) : file_(file) {}

  // Moves to the next row; returns false if there is none.
  bool Next();
  // Moves to the next row, which must exist with at least `least` fields; `what` is the expected
  // item.
  void Require(const char* what, std::size_t least);

  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  std::int64_t Whole(std::size_t field, const char* what, std::int64_t low,
                     std::int64_t high) const;
  [[nodiscard]] double Real(std::size_t field, const char* what) const;
  [[nodiscard]] std::string Where() const override { return file_.Where(); }

 private:
  FileCursor file_;
  std::vector<std::string_view> fields_;
};

}  // namespace palpate
