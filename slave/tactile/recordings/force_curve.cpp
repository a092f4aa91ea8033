#include "slave/tactile/recordings/force_curve.h"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>

#include "shared/text/csv.h"
#include "slave/capture/time_column.h"

namespace palpate {
namespace {

constexpr double kOffsetTime = 0.5;    // [s]
constexpr double kLargestGap = 0.1;    // [s]
constexpr double kLargestForce = 1e6;  // beyond, the number is no force [N]
constexpr const char* kAccepted = "accepted is fx, fy, fz or fx_N, fy_N, fz_N, finite numbers [N]";

using Names = std::array<std::string, 3>;
const std::array<Names, 2> kNames{Names{"fx", "fy", "fz"}, Names{"fx_N", "fy_N", "fz_N"}};

}  // namespace

ForceCurve::ForceCurve(const std::filesystem::path& file, const TactileRecording& recording)
    : t_(recording.t) {
  const auto& columns = recording.others;
  for (const Names& names : kNames) {
    for (const std::string& name : names) {
      const auto refused = recording.refused.find(name);
      if (refused != recording.refused.end()) throw std::runtime_error(refused->second);
    }
    if (!std::ranges::all_of(names, [&](const auto& n) { return columns.contains(n); })) continue;
    const auto &x = columns.at(names[0]), &y = columns.at(names[1]), &z = columns.at(names[2]);
    for (std::size_t i = 0; i < t_.size(); ++i) force_.emplace_back(x[i], y[i], z[i]);
    TakeOffset();
    return;
  }
  throw std::runtime_error(file.string() + ": no force columns: " + kAccepted +
                           ", or a file with them: TACTILE.csv+WRENCH.csv");
}

ForceCurve::ForceCurve(const std::filesystem::path& file) {
  CsvRows rows(file);
  const std::size_t time = FindTimeColumn(rows);
  std::array<std::optional<std::size_t>, 3> columns;
  for (const Names& names : kNames) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (!columns[i]) columns[i] = rows.Find(names[i]);
    }
  }
  if (!columns[0] || !columns[1] || !columns[2]) {
    rows.Fail(std::string("no force columns: ") + kAccepted);
  }
  while (rows.Next()) {
    const double t = ReadTime(rows, time, t_.empty() ? nullptr : &t_.back());
    if (!t_.empty() && t == t_.back()) continue;
    t_.push_back(t);
    force_.emplace_back(rows.Number(*columns[0], kLargestForce),
                        rows.Number(*columns[1], kLargestForce),
                        rows.Number(*columns[2], kLargestForce));
  }
  if (t_.empty()) rows.Fail("no samples: accepted is a header and one row or more");
  TakeOffset();
}

void ForceCurve::TakeOffset() {
  Eigen::Vector3d sum(0, 0, 0);
  std::size_t count = 0;
  for (; count < t_.size() && t_[count] - t_.front() < kOffsetTime; ++count) sum += force_[count];
  const Eigen::Vector3d offset = sum / static_cast<double>(count);
  for (Eigen::Vector3d& f : force_) f -= offset;
}

std::optional<Eigen::Vector3d> ForceCurve::At(double t) const {
  const auto after = std::ranges::lower_bound(t_, t);
  if (after == t_.end()) return std::nullopt;
  const auto i = static_cast<std::size_t>(after - t_.begin());
  if (*after == t) return force_[i];
  if (i == 0 || t_[i] - t_[i - 1] > kLargestGap) return std::nullopt;
  const double share = (t - t_[i - 1]) / (t_[i] - t_[i - 1]);
  return (1 - share) * force_[i - 1] + share * force_[i];
}

}  // namespace palpate
