#include "slave/capture/image_files.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <limits>
#include <memory>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fnmatch.h>
#include <opencv2/core.hpp>

#include "shared/text/file_format.h"
#include "shared/text/text.h"
#include "slave/capture/codecs/codecs.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Refuse(const fs::path& what, const std::string& why) {
  throw std::runtime_error(what.string() + ": " + why);
}

bool IsImageName(const fs::path& file) {
  static const std::vector<std::string> kExtensions = {
      ".png", ".jpg", ".jpeg", ".jpe", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".pnm", ".webp"};
  const std::string extension = Lowercase(file.extension().string());
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

// Regular files of `directory` that `wanted` accepts, sorted naturally.
template <typename Wanted>
std::vector<fs::path> Collect(const fs::path& directory, const Wanted& wanted) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(directory, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file(error) && wanted(it->path())) files.push_back(it->path());
  }
  if (error) Refuse(directory, "cannot be listed: " + error.message());
  std::sort(files.begin(), files.end(), [](const fs::path& a, const fs::path& b) {
    return NaturallyLess(a.filename().string(), b.filename().string());
  });
  return files;
}

// A file name with one %d, %4d or %04d.
struct NumberedName {
  std::string before, after;
  std::size_t width = 0;
  bool zeros = false;

  [[nodiscard]] std::string Name(long number) const {
    std::string digits = std::to_string(number);
    if (digits.size() < width) digits.insert(0, width - digits.size(), zeros ? '0' : ' ');
    return before + digits + after;
  }
  // Returns the number in `name` if the name matches the pattern.
  [[nodiscard]] std::optional<long> Number(const std::string& name) const {
    if (name.size() <= before.size() + after.size()) return std::nullopt;
    const char* const last = name.data() + name.size() - after.size();
    const char* first = name.data() + before.size();
    while (first < last && *first == ' ') ++first;
    long number = 0;
    const auto [end, error] = std::from_chars(first, last, number);
    if (error != std::errc() || number < 0 || end != last || Name(number) != name)
      return std::nullopt;
    return number;
  }
};

NumberedName ParseNumbered(const fs::path& pattern) {
  const std::string name = pattern.filename().string();
  const std::size_t percent = name.find('%');
  const std::size_t digits =
      std::min(name.find_first_not_of("0123456789", percent + 1), name.size());
  const std::string width = name.substr(percent + 1, digits - percent - 1);
  const bool whole = digits < name.size() && name[digits] == 'd' && width.size() <= 3 &&
                     name.find('%', digits) == std::string::npos;
  if (!whole) {
    Refuse(pattern, "malformed pattern: expected one %d, for example %04d.png, in the file name");
  }
  return {name.substr(0, percent), name.substr(digits + 1), width.empty() ? 0U : std::stoul(width),
          !width.empty() && width[0] == '0'};
}

std::vector<fs::path> ListNumbered(const fs::path& pattern) {
  const NumberedName numbered = ParseNumbered(pattern);
  return Collect(pattern.parent_path(), [&](const fs::path& file) {
    return numbered.Number(file.filename().string()).has_value();
  });
}

// The numbers in the files' names, in order of the names. A number that is too long counts as none.
std::optional<std::vector<std::uint64_t>> NumbersOf(const std::vector<fs::path>& files) {
  std::vector<std::uint64_t> numbers;
  for (const fs::path& file : files) {
    const std::string digits = LastNumber(file);
    std::uint64_t number = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
    if (digits.empty() || error != std::errc()) return std::nullopt;
    if (!numbers.empty() && number <= numbers.back()) return std::nullopt;
    numbers.push_back(number);
  }
  return numbers;
}

constexpr std::streamoff kMaxFile = 1'000'000'000;  // more than kMaxPixels need

std::vector<unsigned char> ReadBytes(const fs::path& file, const std::string& which) {
  std::ifstream stream(file, std::ios::binary | std::ios::ate);
  const std::streamoff size = stream ? static_cast<std::streamoff>(stream.tellg()) : -1;
  if (size < 0) Refuse(file, which + " cannot be opened");
  if (size == 0) Refuse(file, which + " is empty");
  if (size > kMaxFile) Refuse(file, which + " is larger than 1 GB");
  std::vector<unsigned char> bytes(static_cast<std::size_t>(size));
  stream.seekg(0);
  if (!stream.read(reinterpret_cast<char*>(bytes.data()), size)) {
    Refuse(file, which + " cannot be read");
  }
  return bytes;
}

cv::Mat WithoutAlpha(const cv::Mat& image) {
  if (image.channels() != 4) return image;
  cv::Mat colour(image.size(), CV_MAKETYPE(image.depth(), 3));
  cv::mixChannels(std::vector<cv::Mat>{image}, std::vector<cv::Mat>{colour}, {0, 0, 1, 1, 2, 2});
  return colour;
}

// An image of a format that only the module reads. Its size is known after decoding.
class OtherImage final : public CodedImage {
 public:
  explicit OtherImage(Bytes bytes) : image_(WithoutAlpha(LoadVideoBackend().Decode(bytes))) {
    if (!image_.empty()) return;
    const std::string_view beginning(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    const std::string foreign = ForeignFormat(beginning);
    throw std::runtime_error(foreign.empty() ? "is not an image, or is damaged" : "is " + foreign);
  }
  [[nodiscard]] cv::Size size() const override { return image_.size(); }
  cv::Mat Decode() override { return image_; }

 private:
  cv::Mat image_;
};

std::unique_ptr<CodedImage> OpenImage(Bytes bytes) {
  auto image = OpenPng(bytes);
  if (!image) image = OpenJpeg(bytes);
  if (!image) image = std::make_unique<OtherImage>(bytes);
  if (const cv::Size size = image->size(); long{size.width} * size.height > kMaxPixels) {
    throw std::runtime_error("is " + std::to_string(size.width) + " x " +
                             std::to_string(size.height) + " px: expected at most " +
                             std::to_string(kMaxPixels / 1'000'000) + " megapixels");
  }
  return image;
}

}  // namespace

std::string LastNumber(const fs::path& file) {
  const std::string stem = file.stem().string();
  const std::size_t last = stem.find_last_of("0123456789");
  if (last == std::string::npos) return {};
  const std::size_t before = stem.find_last_not_of("0123456789", last);
  const std::size_t first = before == std::string::npos ? 0 : before + 1;
  const std::string digits = stem.substr(first, last + 1 - first);
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size() - 1));
}

std::vector<std::uint64_t> InstantsOf(const std::vector<fs::path>& files) {
  std::vector<std::uint64_t> in_turn(files.size());
  std::iota(in_turn.begin(), in_turn.end(), 0);
  const auto numbers = NumbersOf(files);
  if (!numbers || numbers->size() < 2) return in_turn;
  std::uint64_t step = std::numeric_limits<std::uint64_t>::max();
  for (std::size_t k = 1; k < numbers->size(); ++k) {
    step = std::min(step, (*numbers)[k] - (*numbers)[k - 1]);
  }
  std::vector<std::uint64_t> instants;
  for (const std::uint64_t number : *numbers) {
    const std::uint64_t way = number - numbers->front();
    if (way % step != 0) return in_turn;
    instants.push_back(way / step);
  }
  return instants.back() < 2 * files.size() ? instants : in_turn;
}

std::string MissingInWords(const std::vector<std::uint64_t>& instants) {
  if (instants.empty() || instants.back() + 1 == instants.size()) return {};
  return ", " + std::to_string(instants.back() + 1 - instants.size()) + " missing";
}

bool NaturallyLess(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[j])) {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
      continue;
    }
    while (i < a.size() && a[i] == '0') ++i;
    while (j < b.size() && b[j] == '0') ++j;
    const std::size_t a0 = i, b0 = j;
    while (i < a.size() && is_digit(a[i])) ++i;
    while (j < b.size() && is_digit(b[j])) ++j;
    if (i - a0 != j - b0) return i - a0 < j - b0;
    if (const int order = a.compare(a0, i - a0, b, b0, j - b0); order != 0) return order < 0;
  }
  if (i < a.size() || j < b.size()) return i == a.size();
  return a < b;  // the same numbers with different leading zeros
}

std::vector<fs::path> ListImages(const std::string& pattern, const fs::path& base) {
  fs::path full = base / pattern;
  // A name without folder refers to the working directory.
  if (full.parent_path().empty()) full = "." / full;
  const std::string name = full.filename().string();
  if (fs::is_directory(full)) {
    auto files = Collect(full, IsImageName);
    if (files.empty()) Refuse(full, "the directory contains no image");
    return files;
  }
  if (!fs::is_directory(full.parent_path())) {
    Refuse(full, "no such directory: " + full.parent_path().string());
  }
  if (fs::is_regular_file(full)) return {full};
  std::vector<fs::path> files;
  if (name.find('%') != std::string::npos) {
    files = ListNumbered(full);
  } else if (name.find_first_of("*?[") != std::string::npos) {
    files = Collect(full.parent_path(), [&](const fs::path& file) {
      return fnmatch(name.c_str(), file.filename().c_str(), FNM_PERIOD) == 0;
    });
  }
  if (files.empty()) Refuse(full, "no image matches");
  return files;
}

cv::Mat ReadImage(const fs::path& file, std::size_t number, const AcceptSize& accept) {
  const std::string which = "image " + std::to_string(number);
  const std::vector<unsigned char> bytes = ReadBytes(file, which);
  const auto stated = [&](const auto& step) {
    try {
      return step();
    } catch (const std::exception& error) {
      Refuse(file, which + " " + error.what());
    }
  };
  const auto image = stated([&] { return OpenImage(bytes); });
  if (accept) accept(image->size());
  return stated([&] { return image->Decode(); });
}

}  // namespace palpate
