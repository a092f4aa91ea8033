// Parsing and formatting of text and numbers, and whole files.
#pragma once

#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace palpate {

// Error of user input: `file:line: key = value: expected ...`.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Unless `met`, throws std::invalid_argument `name = value unit: expected ...`.
template <class T>
void Require(bool met, const std::string& name, T value, const std::string& accepted,
             const std::string& unit = "") {
  if (met) return;
  throw std::invalid_argument(name + " = " + std::to_string(value) + unit + ": expected " +
                              accepted);
}

// Returns the result of `read`. Rethrows its exceptions as std::runtime_error `file: why`.
template <class Read>
auto NamingFile(const std::filesystem::path& file, const Read& read) {
  try {
    return read();
  } catch (const std::exception& why) {
    throw std::runtime_error(file.string() + ": " + why.what());
  }
}

// Throws std::invalid_argument `name = value: expected ...`, with six digits of the value.
[[noreturn]] void RefuseValue(std::string_view name, double value, std::string_view accepted);
// Throw the same unless the value is finite and > 0, or >= 0.
void RequirePositive(std::string_view name, double value);
void RequireNotNegative(std::string_view name, double value);

// Removes blanks, tabs and line ends at both ends.
std::string_view Trimmed(std::string_view text) noexcept;

// ASCII letters in lower case.
std::string Lowercase(std::string_view text);

// Parses a number in any locale: `12`, `-0.5`, `+3e4`. nullopt: no number, other text, or not
// finite.
std::optional<double> ParseFinite(std::string_view text) noexcept;

// Appends the shortest text that reads back as the same number, in any locale.
template <class T>
void AppendNumber(T value, char separator, std::string* text) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
  text->append(digits.data(), end) += separator;
}

// printf into a string of any length.
__attribute__((format(printf, 1, 2))) std::string Formatted(const char* format, ...);

// Printable form of `text`: at most `most` bytes of whole characters, then `...`. Control
// characters and invalid UTF-8 become `?`.
std::string Shown(std::string_view text, std::size_t most = 60);
// Offset of the first byte that is no UTF-8; npos: all is.
std::size_t FindInvalidUtf8(std::string_view text);
// The characters beyond ASCII as ` (has U+00A0, U+0430)`, at most three: many look like ASCII.
// Empty: there are none.
std::string CodesIn(std::string_view text);
// The first `most` UTF-8 characters of untrusted `text`, safe for a terminal, log or message.
// Control characters (C0, C1) and direction marks become blanks.
std::string Presentable(std::string_view text, std::size_t most);

// Reads a regular file. Throws InputError if it cannot be read or is larger than `most` bytes.
// `accepted`: description of the file, such as "a rig".
std::string ReadWholeFile(const std::filesystem::path& file, std::uintmax_t most,
                          std::string_view accepted);
// Returns false if the file cannot be written.
[[nodiscard]] bool TryWrite(const std::filesystem::path& file, std::string_view bytes);
// Throws std::system_error `file: cannot be written: reason`.
void WriteWholeFile(const std::filesystem::path& file, std::string_view bytes);

// How to treat a symbolic link at the name of a result: it may have been made by the user, or by an
// attacker in a folder that the program chose.
enum class Links : std::uint8_t { kFollow, kReplace };
// Writes to an open file. Returns false on failure.
using FileWriter = std::function<bool(std::FILE*)>;

// Replaces a file atomically: readers find the old or the new one. `write` gets a new file with a
// random name in the same folder. The result keeps the mode of the old file. Devices and pipes are
// written to directly if links are followed. Returns false if the old file was kept.
[[nodiscard]] bool TryReplace(const std::filesystem::path& file, const FileWriter& write,
                              Links links = Links::kFollow);
[[nodiscard]] bool TryReplace(const std::filesystem::path& file, std::string_view bytes,
                              Links links = Links::kFollow);
// Follows links. Throws std::runtime_error `file: cannot be written`.
void ReplaceFile(const std::filesystem::path& file, std::string_view bytes);

// Checks before a computation that its result can be written. Leaves no new file. An empty path is
// ignored. Throws std::invalid_argument `file: cannot be written: ...`.
void RequireWritable(const std::filesystem::path& file);

// Throws std::invalid_argument if `out` of `option`, or one of `names` in the folder `out`, is one
// of the input files, by any path.
void RequireOtherThan(std::string_view option, const std::filesystem::path& out,
                      std::span<const std::filesystem::path> inputs);
void RequireOtherThan(std::string_view option, const std::filesystem::path& out,
                      std::initializer_list<std::string_view> names,
                      std::span<const std::filesystem::path> inputs);

// Escapes `<`, `&`, quotes and control characters for content and attributes of XML.
std::string XmlEscaped(std::string_view text);

}  // namespace palpate
