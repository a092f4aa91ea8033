// Words and numbers of files that people write, and such files as a whole.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace palpate {

// What somebody gave is not usable: `file:line: key = value: accepted is ...`.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Unless `met`, throws std::invalid_argument `name = value unit: accepted is ...`.
template <class T>
void Require(bool met, const std::string& name, T value, const std::string& accepted,
             const std::string& unit = "") {
  if (met) return;
  throw std::invalid_argument(name + " = " + std::to_string(value) + unit + ": accepted is " +
                              accepted);
}

// What `read` gives; what it throws comes as std::runtime_error `file: why`.
template <class Read>
auto NamingFile(const std::filesystem::path& file, const Read& read) {
  try {
    return read();
  } catch (const std::exception& why) {
    throw std::runtime_error(file.string() + ": " + why.what());
  }
}

// Throws std::invalid_argument `name = value: accepted is ...`, with six digits of the value.
[[noreturn]] void RefuseValue(std::string_view name, double value, std::string_view accepted);
// The same unless it is finite and > 0, or >= 0.
void RequirePositive(std::string_view name, double value);
void RequireNotNegative(std::string_view name, double value);

// Without blanks, tabs and line ends around it.
std::string_view Trimmed(std::string_view text) noexcept;

// A number in every locale: `12`, `-0.5`, `+3e4`. nullopt: none, more than that, or not finite.
std::optional<double> ParseFinite(std::string_view text) noexcept;

// Appends the shortest text that reads back as the same number, whatever the locale.
template <class T>
void AppendNumber(T value, char separator, std::string* text) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text->append(digits.data(), end) += separator;
}

// printf into a string, of whatever length.
__attribute__((format(printf, 1, 2))) std::string Formatted(const char* format, ...);

// What people see of `text`: at most `most` bytes of whole characters, `...` where there is more;
// `?` for what moves their cursor and for bytes that are no UTF-8.
std::string Shown(std::string_view text, std::size_t most = 60);
// The first `most` characters of UTF-8 of what a stranger said, fit for a terminal, a log or a
// message: control characters (C0, C1) and what turns the direction of writing become blanks.
std::string Presentable(std::string_view text, std::size_t most);

// The bytes of a regular file. Throws InputError: it cannot be read, or has more than `most` bytes;
// `accepted` in words: "a rig".
std::string ReadWholeFile(const std::filesystem::path& file, std::uintmax_t most,
                          std::string_view accepted);
// False: cannot be written.
[[nodiscard]] bool TryWrite(const std::filesystem::path& file, std::string_view bytes);
// Throws std::runtime_error `file: cannot be written`.
void WriteWholeFile(const std::filesystem::path& file, std::string_view bytes);
// The same, whole or not at all: readers meet the old file or the new one. `write` is given the
// path of what becomes the file; false: it, or this, did not succeed.
[[nodiscard]] bool TryReplace(const std::filesystem::path& file,
                              const std::function<bool(const std::filesystem::path&)>& write);
void ReplaceFile(const std::filesystem::path& file, std::string_view bytes);

// Told before anything is computed that would be lost; a file that was not there is not there
// afterwards. An empty path is none. Throws std::invalid_argument `file: cannot be written: ...`.
void RequireWritable(const std::filesystem::path& file);

// Throws std::invalid_argument: `out`, which `option` names, is one of the files that are read, by
// whatever path; or one of `names` in the folder `out` is.
void RequireOtherThan(std::string_view option, const std::filesystem::path& out,
                      std::span<const std::filesystem::path> inputs);
void RequireOtherThan(std::string_view option, const std::filesystem::path& out,
                      std::initializer_list<std::string_view> names,
                      std::span<const std::filesystem::path> inputs);

}  // namespace palpate
