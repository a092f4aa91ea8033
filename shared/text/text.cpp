#include "shared/text/text.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cinttypes>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <fstream>
#include <system_error>

#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

namespace palpate {

void RefuseValue(std::string_view name, double value, std::string_view accepted) {
  std::array<char, 40> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                 std::chars_format::general, 6);
  throw std::invalid_argument(std::string(name) + " = " + std::string(digits.data(), end.ptr) +
                              ": expected " + std::string(accepted));
}

void RequirePositive(std::string_view name, double value) {
  if (!(value > 0 && std::isfinite(value))) RefuseValue(name, value, "finite and > 0");
}

void RequireNotNegative(std::string_view name, double value) {
  if (!(value >= 0 && std::isfinite(value))) RefuseValue(name, value, "finite and >= 0");
}

std::string Lowercase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return lower;
}

std::string_view Trimmed(std::string_view text) noexcept {
  constexpr std::string_view kBlank = " \t\r\n";
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::optional<double> ParseFinite(std::string_view text) noexcept {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool is_whole = error == std::errc{} && end == text.data() + text.size();
  return is_whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string Formatted(const char* format, ...) {
  va_list arguments, again;
  va_start(arguments, format);
  va_copy(again, arguments);
  std::string text(static_cast<std::size_t>(std::vsnprintf(nullptr, 0, format, again)), '\0');
  va_end(again);
  std::vsnprintf(text.data(), text.size() + 1, format, arguments);
  va_end(arguments);
  return text;
}

namespace {

// Returns the length of the UTF-8 character at the start of `text` (RFC 3629) [bytes]; 0: it is
// invalid.
std::size_t LengthOfFirst(std::string_view text) {
  const auto byte = [text](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead < 0xC2 || lead > 0xF4) return 0;
  // Rejects overlong encodings, surrogates, and values beyond U+10FFFF.
  const unsigned least = lead == 0xE0 ? 0xA0 : lead == 0xF0 ? 0x90 : 0x80;
  const unsigned most = lead == 0xED ? 0x9F : lead == 0xF4 ? 0x8F : 0xBF;
  if (byte(1) < least || byte(1) > most) return 0;
  const std::size_t length = lead < 0xE0 ? 2 : lead < 0xF0 ? 3 : 4;
  for (std::size_t i = 2; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
  }
  return length;
}

// U+0000 to 1F, 7F to 9F, 200E to 200F, 2028 to 202E, 2066 to 2069.
bool MovesCursor(std::string_view c) {
  const auto byte = [c](std::size_t i) { return static_cast<unsigned char>(c[i]); };
  if (c.size() == 1) return byte(0) < 0x20 || byte(0) == 0x7F;
  if (c.size() == 2) return byte(0) == 0xC2 && byte(1) < 0xA0;
  if (c.size() != 3 || byte(0) != 0xE2) return false;
  const bool general = byte(1) == 0x80 &&
                       (byte(2) == 0x8E || byte(2) == 0x8F || (byte(2) >= 0xA8 && byte(2) <= 0xAE));
  return general || (byte(1) == 0x81 && byte(2) >= 0xA6 && byte(2) <= 0xA9);
}

}  // namespace

std::string Shown(std::string_view text, std::size_t most) {
  std::string shown;
  while (!text.empty()) {
    const std::size_t length = LengthOfFirst(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    const bool is_fit = length > 0 && !MovesCursor(character);
    const std::string_view seen = is_fit ? character : "?";
    if (shown.size() + seen.size() > most) return shown + "...";
    shown.append(seen);
    text.remove_prefix(character.size());
  }
  return shown;
}

std::size_t FindInvalidUtf8(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = LengthOfFirst(text.substr(at));
    if (length == 0) return at;
    at += length;
  }
  return std::string_view::npos;
}

std::string CodesIn(std::string_view text) {
  constexpr int kMaxCount = 3;
  std::string codes;
  for (int count = 0; !text.empty() && count < kMaxCount;) {
    const std::size_t length = std::max<std::size_t>(LengthOfFirst(text), 1);
    if (length > 1) {
      const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
      unsigned code = byte(0) & (0xFFU >> (length + 1));
      for (std::size_t i = 1; i < length; ++i) code = code << 6U | (byte(i) & 0x3FU);
      const std::string name = Formatted("U+%04X", code);
      if (codes.find(name) == std::string::npos) {
        codes.append(codes.empty() ? " (has " : ", ").append(name);
        ++count;
      }
    }
    text.remove_prefix(length);
  }
  return codes.empty() ? codes : codes + ")";
}

std::string Presentable(std::string_view text, std::size_t most) {
  std::string shown;
  for (std::size_t count = 0; !text.empty() && count < most; ++count) {
    const std::size_t length = LengthOfFirst(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
    shown.append(length == 0 || MovesCursor(character) ? " " : character);
    text.remove_prefix(character.size());
  }
  return shown;
}

std::string ReadWholeFile(const std::filesystem::path& file, std::uintmax_t most,
                          std::string_view accepted) {
  const auto refuse = [&](const char* what) {
    throw InputError(file.string() + ": " + what + ": expected " + std::string(accepted) +
                     " of at most " + std::to_string(most >> 20U) + " MiB");
  };
  std::error_code error;
  std::ifstream stream(file, std::ios::binary);
  if (!std::filesystem::is_regular_file(file, error) || !stream) refuse("cannot be read");
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error || size > most) refuse(error ? "cannot be read" : "too large");
  std::string bytes(static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(size));
  if (stream.bad()) refuse("cannot be read");
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

namespace {

constexpr mode_t kMode = 0666;  // permissions before the umask is applied

// Returns a descriptor; -1 if the file cannot be written or is a pipe without a reader (does not
// wait for one).
int OpenToWrite(const std::filesystem::path& file, int flags) {
  const int opened = open(file.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC | flags, kMode);
  if (opened >= 0) fcntl(opened, F_SETFL, 0);
  return opened;
}

// Opens a new file in the folder of `file`. Its random name excludes prepared symbolic links.
int OpenBeside(const std::filesystem::path& file, mode_t mode, std::filesystem::path* part) {
  std::uint64_t random = 0;
  if (getrandom(&random, sizeof random, 0) != sizeof random) return -1;
  *part = file.parent_path() / Formatted("palpate-%016" PRIx64 ".part", random);
  return open(part->c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
}

// Closes the file. False: not everything was written.
bool Fill(int opened, const FileWriter& write) {
  std::FILE* const file = opened < 0 ? nullptr : fdopen(opened, "wb");
  if (file == nullptr) return false;
  const bool written = write(file);
  return std::fclose(file) == 0 && written;
}

FileWriter WriterOf(std::string_view bytes) {
  return [bytes](std::FILE* file) {
    return std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size();
  };
}

}  // namespace

bool TryWrite(const std::filesystem::path& file, std::string_view bytes) {
  return Fill(OpenToWrite(file, O_CREAT | O_TRUNC), WriterOf(bytes));
}

void WriteWholeFile(const std::filesystem::path& file, std::string_view bytes) {
  if (TryWrite(file, bytes)) return;
  throw std::system_error(errno, std::generic_category(), file.string() + ": cannot be written");
}

bool TryReplace(const std::filesystem::path& file, const FileWriter& write, Links links) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const bool follows = links == Links::kFollow;
  const auto status = follows ? fs::status(file, ignored) : fs::symlink_status(file, ignored);
  const bool is_file = fs::is_regular_file(status);
  // A device or a pipe, such as /dev/null, must not be replaced by a file.
  if (follows && !is_file && fs::exists(status)) return Fill(OpenToWrite(file, O_TRUNC), write);
  const fs::path replaced = follows && is_file ? fs::canonical(file, ignored) : file;
  const mode_t mode = is_file ? static_cast<mode_t>(status.permissions()) & 0777U : kMode;
  fs::path part;
  const int opened = OpenBeside(replaced, mode, &part);
  if (opened < 0) return false;
  if (is_file) fchmod(opened, mode);  // whatever the umask
  const bool done = Fill(opened, write) && std::rename(part.c_str(), replaced.c_str()) == 0;
  if (!done) fs::remove(part, ignored);
  return done;
}

bool TryReplace(const std::filesystem::path& file, std::string_view bytes, Links links) {
  return TryReplace(file, WriterOf(bytes), links);
}

void ReplaceFile(const std::filesystem::path& file, std::string_view bytes) {
  if (TryReplace(file, bytes)) return;
  throw std::runtime_error(file.string() + ": cannot be written");
}

void RequireWritable(const std::filesystem::path& file) {
  if (file.empty()) return;
  int opened = OpenToWrite(file, 0);
  std::filesystem::path part;
  if (opened < 0 && errno == ENOENT) opened = OpenBeside(file, kMode, &part);
  std::error_code ignored;
  const bool is_pipe = std::filesystem::is_fifo(file, ignored);
  if (opened < 0) {
    throw std::invalid_argument(file.string() + ": cannot be written: expected " +
                                (is_pipe ? "a pipe with a reader"
                                         : "a file in a folder that exists and may be written to"));
  }
  if (!part.empty()) std::filesystem::remove(part, ignored);
  // A pipe remains open until the program ends, because its reader would take a close for the end.
  if (!is_pipe) close(opened);
}

void RequireOtherThan(std::string_view option, const std::filesystem::path& out,
                      std::span<const std::filesystem::path> inputs) {
  for (const auto& input : inputs) {
    std::error_code error;  // set if a file does not exist
    if (out.empty() || !std::filesystem::equivalent(out, input, error) || error) continue;
    throw std::invalid_argument(std::string(option) + " " + out.string() +
                                ": expected another file than " + input.string() +
                                ", which is read");
  }
}

void RequireOtherThan(std::string_view option, const std::filesystem::path& out,
                      std::initializer_list<std::string_view> names,
                      std::span<const std::filesystem::path> inputs) {
  for (const std::string_view name : names) RequireOtherThan(option, out / name, inputs);
}

std::string XmlEscaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '<') {
      escaped += "&lt;";
    } else if (c == '>') {
      escaped += "&gt;";
    } else if (c == '&') {
      escaped += "&amp;";
    } else if (c == '"') {
      escaped += "&quot;";
    } else {
      escaped += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return escaped;
}

}  // namespace palpate
