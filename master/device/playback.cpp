#include "master/device/playback.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "shared/text/csv.h"

namespace palpate {
namespace {

constexpr std::array<std::string_view, 4> kColumns{"time_s", "x", "y", "z"};
constexpr double kFarthest = 100;     // [m]
constexpr double kRemarkedGap = 0.5;  // [s]

std::array<std::size_t, 4> FindColumns(const CsvLines& rows) {
  std::array<std::size_t, 4> columns{};
  for (std::size_t i = 0; i < kColumns.size(); ++i) {
    const auto found = std::ranges::find(rows.cells(), kColumns[i]);
    if (found == rows.cells().end()) {
      rows.Fail("column " + std::string(kColumns[i]) +
                " is missing: expected a header row with time_s, x, y, z");
    }
    columns[i] = static_cast<std::size_t>(found - rows.cells().begin());
  }
  return columns;
}

double Number(const CsvLines& row, std::size_t column, std::string_view name) {
  const auto text = column < row.cells().size() ? row.cells()[column] : std::string_view{};
  const auto value = ParseFinite(text);
  if (!value) {
    row.Fail(std::string(name) + " = '" + Shown(text) + "': expected a finite number");
  }
  return *value;
}

// A recorded hand feels nothing, and therefore has no limit of its own.
DeviceCapabilities WithoutForce() {
  DeviceCapabilities own;
  own.simulated = true;
  return own;
}

}  // namespace

Playback::Playback(const std::filesystem::path& file) : HapticDevice(WithoutForce()), file_(file) {
  CsvLines lines(file);
  if (!lines.Next()) lines.Fail("empty: expected a header row with time_s, x, y, z");
  const auto columns = FindColumns(lines);
  while (lines.Next()) {
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = Number(lines, columns[i], kColumns[i]);
    }
    const Row row{values[0], {values[1], values[2], values[3]}};
    if (!rows_.empty() && !(row.t > rows_.back().t)) {
      lines.Fail("time_s = " + std::to_string(row.t) + " s: expected more than the row before");
    }
    if (!(row.p.norm() <= kFarthest)) lines.Fail("position beyond 100 m: expected less");
    if (!rows_.empty()) longest_gap_ = std::max(longest_gap_, row.t - rows_.back().t);
    rows_.push_back(row);
  }
  if (rows_.size() < 2) {
    lines.Fail(std::to_string(rows_.size()) + " rows: expected at least 2");
  }
}

DeviceReading Playback::DoRead(Time now) noexcept {
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
  const std::string gap = Formatted("; gaps up to %g s are interpolated linearly", longest_gap_);
  return "playback of " + file_.filename().string() + ": " + std::to_string(rows_.size()) +
         Formatted(" rows, %g s", rows_.back().t - rows_.front().t) +
         (longest_gap_ > kRemarkedGap ? gap : "");
}

}  // namespace palpate
