// Where recorded fingertips were: a CSV file of poses.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "slave/scene/scene.h"

namespace palpate {

// Columns `t,finger,x,y,z,qw,qx,qy,qz`: time on the recording's clock [s] (or another of its
// names), finger as the scene calls it (without the column: all fingers), origin of F in S [m],
// rotation of F in S as a quaternion of length one to 1 %. Rows of fingers that the scene does not
// have are passed over, and of two at the same time the second.
class FingerPoses {
 public:
  // Throws std::runtime_error `file:line: ...`: unreadable, a column missing, not a finite number,
  // no unit quaternion, a finger's clock that goes back, no pose of any of `fingers`. `hold`: for
  // so long the first pose counts before its time and the last one after it [s].
  FingerPoses(const std::filesystem::path& file, const std::vector<Finger>& fingers, double hold);

  // X_SF of `finger` at `t` [s]: between two poses linear in place and spherically linear in
  // rotation. nullopt: the file has none of it for this time.
  [[nodiscard]] std::optional<Eigen::Isometry3d> At(std::string_view finger, double t) const;
  // Throws std::runtime_error naming both: no pose of any finger counts from `begin` to `end` [s].
  void RequireWithin(double begin, double end) const;

 private:
  struct Pose {
    double t = 0;
    Eigen::Isometry3d X_SF = Eigen::Isometry3d::Identity();
  };
  std::filesystem::path file_;
  double hold_;
  std::map<std::string, std::vector<Pose>, std::less<>> poses_;  // by finger, times rising
};

}  // namespace palpate
