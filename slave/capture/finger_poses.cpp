#include "slave/capture/finger_poses.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "slave/capture/csv_rows.h"
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

std::array<double, kNumbers.size()> ReadNumbers(const CsvRows& rows, const NumberColumns& columns) {
  std::array<double, kNumbers.size()> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = rows.Number(columns[i], kFarthest);
  const double length = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
  if (!(std::abs(length - 1) <= kUnitTolerance)) {
    rows.Fail("qw,qx,qy,qz of length " + std::to_string(length) +
              ": accepted is a unit quaternion");
  }
  return v;
}

}  // namespace

FingerPoses::FingerPoses(const std::filesystem::path& file, const std::vector<Finger>& fingers) {
  CsvRows rows(file);
  const std::size_t time = FindTimeColumn(rows);
  const NumberColumns columns = FindNumbers(rows);
  const auto name = rows.Find("finger");
  while (rows.Next()) {
    const auto v = ReadNumbers(rows, columns);
    for (const Finger& finger : fingers) {
      if (name && rows.Text(*name) != finger.name) continue;
      auto& poses = poses_[finger.name];
      const double t = ReadTime(rows, time, poses.empty() ? nullptr : &poses.back().t);
      if (!poses.empty() && t == poses.back().t) continue;
      poses.push_back(
          {t, {v[0], v[1], v[2]}, Eigen::Quaterniond(v[3], v[4], v[5], v[6]).normalized()});
    }
  }
  if (poses_.empty()) rows.Fail("no pose: accepted is one row or more of the scene's fingers");
}

std::optional<Eigen::Isometry3d> FingerPoses::At(std::string_view finger, double t) const {
  const auto found = poses_.find(finger);
  if (found == poses_.end()) return std::nullopt;
  const std::vector<Pose>& poses = found->second;
  const auto after = std::ranges::upper_bound(poses, t, {}, &Pose::t);
  const Pose& to = after == poses.end() ? poses.back() : *after;
  const Pose& from = after == poses.begin() ? to : *std::prev(after);
  const double share = to.t > from.t ? (t - from.t) / (to.t - from.t) : 0;
  Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  X_SF.translate((1 - share) * from.p_S + share * to.p_S).rotate(from.q_SF.slerp(share, to.q_SF));
  return X_SF;
}

}  // namespace palpate
