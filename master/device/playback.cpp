#include "master/device/playback.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string_view>

namespace palpate {
namespace {

constexpr std::array<std::string_view, 4> kColumns{"time_s", "x", "y", "z"};
constexpr double kFarthest = 100;     // [m]
constexpr double kRemarkedGap = 0.5;  // [s]

class Reader {
 public:
  explicit Reader(const std::filesystem::path& file) : file_(file), in_(file) {
    if (!in_) throw std::runtime_error(file.string() + ": cannot be read");
  }
  // The cells of the next line that is not blank. False: the end.
  bool Next(std::vector<std::string_view>* cells) {
    while (std::getline(in_, line_)) {
      ++number_;
      Split(cells);
      if (cells->size() > 1 || !cells->front().empty()) return true;
    }
    return false;
  }
  [[noreturn]] void Fail(const std::string& what) const {
    throw std::runtime_error(file_.string() + ":" + std::to_string(number_) + ": " + what);
  }

 private:
  void Split(std::vector<std::string_view>* cells) const {
    cells->clear();
    std::string_view rest = line_;
    while (true) {
      const auto comma = rest.find(',');
      cells->push_back(Trim(rest.substr(0, comma)));
      if (comma == std::string_view::npos) return;
      rest.remove_prefix(comma + 1);
    }
  }
  static std::string_view Trim(std::string_view text) {
    const auto first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
  }

  std::filesystem::path file_;
  std::ifstream in_;
  std::string line_;
  int number_ = 0;
};

std::array<std::size_t, 4> FindColumns(const Reader& reader,
                                       const std::vector<std::string_view>& header) {
  std::array<std::size_t, 4> columns{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::find(header.begin(), header.end(), kColumns[i]);
    if (found == header.end()) {
      reader.Fail("column " + std::string(kColumns[i]) +
                  " is missing: accepted is a header row with time_s, x, y, z");
    }
    columns[i] = static_cast<std::size_t>(found - header.begin());
  }
  return columns;
}

double Number(const Reader& reader, const std::vector<std::string_view>& cells, std::size_t column,
              std::string_view name) {
  const std::string_view text = column < cells.size() ? cells[column] : std::string_view{};
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc{} && end == text.data() + text.size();
  if (!whole || !std::isfinite(value)) {
    reader.Fail(std::string(name) + " = '" + std::string(text) + "': accepted is a finite number");
  }
  return value;
}

}  // namespace

Playback::Playback(const std::filesystem::path& file) : file_(file) {
  Reader reader(file);
  std::vector<std::string_view> cells;
  if (!reader.Next(&cells)) reader.Fail("empty: accepted is a header row with time_s, x, y, z");
  const auto columns = FindColumns(reader, cells);
  while (reader.Next(&cells)) {
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = Number(reader, cells, columns[i], kColumns[i]);
    }
    const Row row{values[0], {values[1], values[2], values[3]}};
    if (!rows_.empty() && !(row.t > rows_.back().t)) {
      reader.Fail("time_s = " + std::to_string(row.t) + " s: accepted is more than the row before");
    }
    if (!(row.p.norm() <= kFarthest)) reader.Fail("position beyond 100 m: accepted is less");
    if (!rows_.empty()) longest_gap_ = std::max(longest_gap_, row.t - rows_.back().t);
    rows_.push_back(row);
  }
  if (rows_.size() < 2) {
    reader.Fail(std::to_string(rows_.size()) + " rows: accepted is at least 2");
  }
}

DeviceReading Playback::Read(Time now) noexcept {
  const bool first = !start_;
  if (first) start_ = now;
  const double t = rows_.front().t + std::max(0.0, SecondsBetween(*start_, now));
  if (t >= rows_.back().t) {
    finished_ = true;
    return {rows_.back().p, Eigen::Vector3d::Zero(), false};
  }
  while (t >= rows_[piece_ + 1].t) ++piece_;
  const Row& from = rows_[piece_];
  const Row& to = rows_[piece_ + 1];
  const double share = (t - from.t) / (to.t - from.t);
  return {from.p + share * (to.p - from.p), (to.p - from.p) / (to.t - from.t), !first};
}

std::string Playback::description() const {
  std::ostringstream text;
  text << "playback of " << file_.filename().string() << ": " << rows_.size() << " rows, "
       << rows_.back().t - rows_.front().t << " s";
  if (longest_gap_ > kRemarkedGap) {
    text << "; a gap of " << longest_gap_ << " s is crossed in a straight line";
  }
  return text.str();
}

}  // namespace palpate
