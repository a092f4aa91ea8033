// Where the other camera of a pair may see what is seen at one pixel: the pixel's ray, walked from
// infinity towards the cameras.
#pragma once

#include <optional>

#include <Eigen/Geometry>

#include "slave/vision/stereo/rig.h"
#include "slave/vision/texture/window_template.h"

namespace palpate {

// Depths need no bounds: the walk goes from infinity to where the line leaves the other picture. A
// place of the line is told by q = baseline / depth, which makes pictures of it nearly evenly
// spaced. Real-time safe. The lenses must outlive it.
class EpipolarLine {
 public:
  // `p_F` in the picture of `from` [px]; X_TF: p_to = X_TF p_from.
  EpipolarLine(const Lens& from, const Lens& to, const Eigen::Isometry3d& X_TF,
               const Eigen::Vector2d& p_F) noexcept;

  // To a place of the other picture about `step` [px] nearer, the first time to infinity. False:
  // the line shows no more of itself.
  bool Next(double step) noexcept;
  [[nodiscard]] double q() const { return q_; }
  // Of the ray at this q [px]; nullopt: the lens cannot show it. It may be outside the picture.
  [[nodiscard]] const std::optional<Eigen::Vector2d>& place() const { return place_; }
  [[nodiscard]] bool in_picture() const { return place_ && IsInside(*place_); }
  // Of the ray through a neighbour of the pixel, as far away [px].
  [[nodiscard]] std::optional<Eigen::Vector2d> Neighbour(const Eigen::Vector2d& p_F) const noexcept;

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> Picture(const Eigen::Vector2d& ray,
                                                       double q) const noexcept;
  [[nodiscard]] bool IsInside(const Eigen::Vector2d& p) const;
  [[nodiscard]] bool Leaves(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const;

  const Lens& from_;
  const Lens& to_;
  Eigen::Matrix3d R_TF_;
  Eigen::Vector3d t_TF_;  // in baselines
  std::optional<Eigen::Vector2d> ray_, place_;
  double q_ = 0, dq_ = 0;
};

// The smallest depth on the left camera's axis that the right one shows too [m]: a disparity of
// half the picture where the axes are parallel. nullopt: it shows nothing of that axis.
std::optional<double> NearestInBoth(const StereoRig& rig) noexcept;

// Where a window seen by one camera is in the other: along the line of places its ray may have.
struct EpipolarOptions {
  double least_correlation = 0.7;  // at the coarse level
  double least_margin = 0.03;      // over the best elsewhere: what looks alike twice is refused
};

// `seen` in the picture of `from`; its window, as `window` has it on `level`, is looked for in
// `picture`, taken by `to`, from infinity to as near as both cameras can see; X_TF: p_to = X_TF
// p_from. nullopt: not there, or there twice. Real-time safe.
std::optional<WindowWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                         const Eigen::Isometry3d& X_TF, const WindowWarp& seen,
                                         WindowTemplate& window, const PicturePyramid& picture,
                                         int level, const EpipolarOptions& options) noexcept;

}  // namespace palpate
