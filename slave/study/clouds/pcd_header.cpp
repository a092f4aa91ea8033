#include "slave/study/clouds/pcd_header.h"

#include <algorithm>
#include <charconv>
#include <map>
#include <sstream>
#include <stdexcept>

namespace palpate::study {
namespace {

using Words = std::vector<std::string>;
constexpr std::size_t kLongestLine = 4096;
constexpr std::size_t kMostFields = 64, kMostValues = 1024;

struct Line {
  int number = 0;
  Words values;
};

class Reader {
 public:
  Reader(const std::filesystem::path& file, std::string_view content)
      : file_(file), content_(content) {}

  PcdHeader Read() {
    ReadLines();
    ReadFields();
    const std::size_t width = Count("WIDTH"), height = Count("HEIGHT");
    header_.points = lines_.contains("POINTS") ? Count("POINTS") : width * height;
    if (header_.points != width * height) {
      Refuse(lines_["HEIGHT"].number, "POINTS = " + std::to_string(header_.points),
             "WIDTH x HEIGHT = " + std::to_string(width) + " x " + std::to_string(height));
    }
    ReadData();
    RequireBytes();
    return header_;
  }

 private:
  [[noreturn]] void Refuse(int line, const std::string& what, const std::string& accepted) const {
    throw std::invalid_argument(file_.string() + ":" + std::to_string(line) + ": " + what +
                                ": accepted is " + accepted);
  }

  void ReadLines() {
    static constexpr auto kKeys = {"VERSION", "FIELDS", "COLUMNS",   "SIZE",   "TYPE", "COUNT",
                                   "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
    while (header_.end < content_.size()) {
      const std::size_t length = content_.substr(header_.end, kLongestLine).find('\n');
      ++header_.lines;
      if (length == std::string_view::npos) break;
      std::istringstream cut(std::string(content_.substr(header_.end, length)));
      header_.end += length + 1;
      std::string key;
      if (!(cut >> key) || key.front() == '#') continue;
      if (std::ranges::find(kKeys, key) == kKeys.end()) break;
      Line& line = lines_[key == "COLUMNS" ? "FIELDS" : key];
      line.number = header_.lines;
      line.values.clear();
      for (std::string word; cut >> word;) line.values.push_back(word);
      if (key == "DATA") return;
    }
    Refuse(header_.lines, "no PCD header",
           "VERSION, FIELDS, SIZE, TYPE, COUNT, WIDTH, HEIGHT, "
           "VIEWPOINT, POINTS and, last, DATA, each on a line");
  }

  const Line& Need(const std::string& key) {
    const auto found = lines_.find(key);
    if (found == lines_.end()) Refuse(header_.lines, key + " missing", "a line " + key);
    return found->second;
  }

  std::size_t Number(const Line& line, const std::string& key, const std::string& word) const {
    std::size_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    // What is larger than a file can be is refused here, so that products of two do not overflow.
    if (error != std::errc{} || end != word.data() + word.size() || value > 0xFFFFFFFFU) {
      Refuse(line.number, key + " = " + word, "a whole number from 0 to 4294967295");
    }
    return value;
  }
  std::size_t Count(const std::string& key) {
    const Line& line = Need(key);
    if (line.values.size() != 1) Refuse(line.number, key, "one whole number");
    return Number(line, key, line.values[0]);
  }

  void ReadFields() {
    const Line& names = Need("FIELDS");
    const Line &sizes = Need("SIZE"), &types = Need("TYPE");
    const std::size_t n = names.values.size();
    if (n == 0 || n > kMostFields) Refuse(names.number, "FIELDS", "1 to 64 names");
    const bool has_counts = lines_.contains("COUNT");
    const Line& counts = has_counts ? Need("COUNT") : names;
    for (const Line* line : {&sizes, &types, &counts}) {
      if (line->values.size() != n) {
        Refuse(line->number, std::to_string(line->values.size()) + " values",
               std::to_string(n) + ", one per field");
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t size = Number(sizes, "SIZE", sizes.values[i]);
      const std::string& type = types.values[i];
      const std::size_t count = has_counts ? Number(counts, "COUNT", counts.values[i]) : 1;
      if (size != 1 && size != 2 && size != 4 && size != 8) {
        Refuse(sizes.number, "SIZE = " + sizes.values[i], "1, 2, 4 or 8");
      }
      if (type != "I" && type != "U" && !(type == "F" && size >= 4)) {
        Refuse(types.number, "TYPE = " + type, "I or U, or F of SIZE 4 or 8");
      }
      if (count < 1 || count > kMostValues) {
        Refuse(counts.number, "COUNT = " + counts.values[i], "1 to 1024");
      }
      header_.fields.push_back({names.values[i], static_cast<int>(size), type[0], count,
                                header_.stride, header_.columns});
      header_.stride += header_.fields.back().bytes();
      header_.columns += count;
    }
  }

  void ReadData() {
    const Line& line = Need("DATA");
    const std::string form = line.values.size() == 1 ? line.values[0] : "";
    if (form == "ascii") {
      header_.data = PcdHeader::Data::kAscii;
    } else if (form == "binary") {
      header_.data = PcdHeader::Data::kBinary;
    } else if (form == "binary_compressed") {
      header_.data = PcdHeader::Data::kCompressed;
    } else {
      Refuse(line.number, "DATA = " + form, "ascii, binary or binary_compressed");
    }
  }

  // Nothing is allocated for points that cannot be there.
  void RequireBytes() const {
    const std::size_t left = content_.size() - header_.end;
    std::size_t room = left / header_.stride;
    // A value and the blank behind it; the last line may end without.
    if (header_.data == PcdHeader::Data::kAscii) room = (left + 1) / (2 * header_.columns);
    // A repeat of LZF makes at most 264 bytes of 3.
    if (header_.data == PcdHeader::Data::kCompressed) room = left * 88 / header_.stride;
    if (header_.points > room) {
      throw std::invalid_argument(file_.string() + ": POINTS = " + std::to_string(header_.points) +
                                  ": accepted is what the file has bytes for, at most " +
                                  std::to_string(room) + " (is it cut off?)");
    }
  }

  const std::filesystem::path& file_;
  std::string_view content_;
  std::map<std::string, Line> lines_;
  PcdHeader header_;
};

}  // namespace

const PcdField* PcdHeader::Find(std::string_view name) const {
  const auto found = std::ranges::find(fields, name, &PcdField::name);
  return found == fields.end() ? nullptr : &*found;
}

PcdHeader ReadPcdHeader(const std::filesystem::path& file, std::string_view content) {
  return Reader(file, content).Read();
}

}  // namespace palpate::study
