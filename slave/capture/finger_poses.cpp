#include "slave/capture/finger_poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "shared/text/csv.h"
#include "slave/capture/tactile_instants.h"
#include "slave/capture/time_column.h"

namespace palpate {
namespace {

constexpr double kFarthest = 1e6;        // [m]
constexpr double kUnitTolerance = 0.01;  // of a quaternion's length

constexpr std::array kNumbers{"x", "y", "z", "qw", "qx", "qy", "qz"};
using NumberColumns = std::array<std::size_t, kNumbers.size()>;

NumberColumns FindNumbers(const CsvRows& rows) {
  NumberColumns columns{};
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto found = rows.Find(kNumbers[i]);
    if (!found) {
      rows.Fail(std::string("column ") + kNumbers[i] +
                " is missing: accepted is t,finger,x,y,z,qw,qx,qy,qz");
    }
    columns[i] = *found;
  }
  return columns;
}

Eigen::Isometry3d ReadPose(const CsvRows& rows, const NumberColumns& columns) {
  std::array<double, kNumbers.size()> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = rows.Number(columns[i], kFarthest);
  const Eigen::Quaterniond q_SF(v[3], v[4], v[5], v[6]);
  if (!(std::abs(q_SF.norm() - 1) <= kUnitTolerance)) {
    rows.Fail("qw,qx,qy,qz of length " + std::to_string(q_SF.norm()) +
              ": accepted is a unit quaternion");
  }
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  X_SF.translate(Eigen::Vector3d(v[0], v[1], v[2])).rotate(q_SF.normalized());
  return X_SF;
}

}  // namespace

FingerPoses::FingerPoses(const std::filesystem::path& file, const std::vector<Finger>& fingers,
                         double hold)
    : file_(file), hold_(hold) {
  CsvRows rows(file);
  const std::size_t time = FindTimeColumn(rows);
  const NumberColumns columns = FindNumbers(rows);
  const auto name = rows.Find("finger");
  while (rows.Next()) {
    const Eigen::Isometry3d X_SF = ReadPose(rows, columns);
    for (const Finger& finger : fingers) {
      if (name && rows.Text(*name) != finger.name) continue;
      auto& poses = poses_[finger.name];
      const double t = ReadTime(rows, time, poses.empty() ? nullptr : &poses.back().t);
      if (!poses.empty() && t == poses.back().t) continue;
      poses.push_back({t, X_SF});
    }
  }
  if (poses_.empty()) rows.Fail("no pose: accepted is one row or more of the scene's fingers");
}

std::optional<Eigen::Isometry3d> FingerPoses::At(std::string_view finger, double t) const {
  const auto found = poses_.find(finger);
  if (found == poses_.end()) return std::nullopt;
  const std::vector<Pose>& poses = found->second;
  if (t < poses.front().t - hold_ || t > poses.back().t + hold_) return std::nullopt;
  const auto after = std::ranges::upper_bound(poses, t, {}, &Pose::t);
  const Pose& to = after == poses.end() ? poses.back() : *after;
  const Pose& from = after == poses.begin() ? to : *std::prev(after);
  return to.t > from.t ? Between(from.X_SF, to.X_SF, (t - from.t) / (to.t - from.t)) : to.X_SF;
}

void FingerPoses::RequireWithin(double begin, double end) const {
  double first = std::numeric_limits<double>::infinity(), last = -first;
  for (const auto& [finger, poses] : poses_) {
    if (poses.front().t <= end + hold_ && poses.back().t >= begin - hold_) return;
    first = std::min(first, poses.front().t);
    last = std::max(last, poses.back().t);
  }
  throw std::runtime_error(fmt::format(
      "{}: poses from {:.6g} to {:.6g} s: accepted are poses on the recording's clock, {:.6g} to "
      "{:.6g} s",
      file_.string(), first, last, begin, end));
}

}  // namespace palpate
