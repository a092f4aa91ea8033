#include "master/device/playback.h"

#include <algorithm>

#include "shared/text/csv.h"
#include "shared/text/plausible.h"

namespace palpate {
namespace {

constexpr double kRemarkedGap = 0.5;  // [s]

void RequireColumns(const CsvTable& table) {
  for (const char* name : {"time_s", "x", "y", "z"}) {
    if (table.Has(name)) continue;
    std::string titles;
    for (const std::string& title : table.header()) titles += (titles.empty() ? "" : ", ") + title;
    table.Fail("column " + std::string(name) + " is missing: there are " + Shown(titles) +
               ": expected a header row with time_s, x, y, z, where a unit may follow, x (mm)");
  }
}

// A recorded motion renders no force, and therefore has no limit of its own.
DeviceCapabilities WithoutForce() {
  DeviceCapabilities own;
  own.simulated = true;
  return own;
}

}  // namespace

Playback::Playback(const std::filesystem::path& file) : HapticDevice(WithoutForce()), file_(file) {
  CsvTable table(file);
  RequireColumns(table);
  while (table.Next()) {
    const Row row{table.Number("time_s"),
                  {table.Number("x"), table.Number("y"), table.Number("z")}};
    if (!rows_.empty() && !(row.t > rows_.back().t)) {
      table.Fail("time_s = " + std::to_string(row.t) + " s: expected more than the row before");
    }
    const double farthest = row.p.cwiseAbs().maxCoeff();
    if (const auto remark = ImplausibleRemark("position", farthest, Plausible::kHandPosition)) {
      table.Fail(*remark + ": name the unit of a column that is not in metres, as in x (mm)");
    }
    if (!rows_.empty()) max_gap_ = std::max(max_gap_, row.t - rows_.back().t);
    rows_.push_back(row);
  }
  if (rows_.size() < 2) {
    table.Fail(std::to_string(rows_.size()) + " rows: expected at least 2");
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
  const std::string gap = Formatted("; gaps up to %g s are interpolated linearly", max_gap_);
  return "playback of " + file_.filename().string() + ": " + std::to_string(rows_.size()) +
         Formatted(" rows, %g s", rows_.back().t - rows_.front().t) +
         (max_gap_ > kRemarkedGap ? gap : "");
}

}  // namespace palpate
