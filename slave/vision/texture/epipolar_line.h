// Search line in the other camera's image for one pixel: the pixel's ray, from infinity towards the
// cameras.
#pragma once

#include <optional>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/vision/patch_aligner.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {

// The depth is not limited: the search extends from infinity to the point where the line leaves the
// other image. The position on the line is q = baseline / depth, whose projections are nearly
// evenly spaced. Real-time safe. The lenses must outlive it.
class EpipolarLine {
 public:
  // `p_F` in the image of `from` [px]; X_TF: p_to = X_TF p_from.
  EpipolarLine(const Lens& from, const Lens& to, const Eigen::Isometry3d& X_TF,
               const Eigen::Vector2d& p_F) noexcept;

  // Advances to a position about `step` [px] nearer, the first time to infinity. False: the end of
  // the line.
  bool Next(double step) noexcept;
  [[nodiscard]] double q() const { return q_; }
  // Returns the projection of the ray at this q [px]; nullopt: outside the lens's range. It may be
  // outside the image.
  [[nodiscard]] const std::optional<Eigen::Vector2d>& place() const { return place_; }
  [[nodiscard]] bool in_image() const { return place_ && IsInside(*place_); }
  // Returns the image of the point on the ray through a neighbouring pixel at the same distance
  // [px].
  [[nodiscard]] std::optional<Eigen::Vector2d> Neighbour(const Eigen::Vector2d& p_F) const noexcept;

 private:
  [[nodiscard]] std::optional<Eigen::Vector2d> Image(const Eigen::Vector2d& ray,
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

// Returns the smallest depth on the left camera's axis that is visible in the right camera [m]: for
// parallel axes a disparity of half the image. nullopt: no part of that axis is visible.
std::optional<double> NearestInBoth(const StereoRig& rig) noexcept;

// Finds a window of one camera in the other's image: along the possible projections of its ray.
struct EpipolarOptions {
  double min_correlation = 0.7;  // at the coarse level
  // Smallest margin over the best score elsewhere; ambiguous matches are rejected.
  double min_margin = 0.03;
};

// `seen` in the image of `from`; its window on `level` is searched in `image`, taken by `to` and
// on the same level, from infinity to the nearest depth that both cameras see; X_TF: p_to = X_TF
// p_from. nullopt: not found, or ambiguous. Real-time safe.
std::optional<PatchWarp> SearchEpipolar(const Lens& from, const Lens& to,
                                        const Eigen::Isometry3d& X_TF, const PatchWarp& seen,
                                        PatchAligner& window, const cv::Mat& image, int level,
                                        const EpipolarOptions& options) noexcept;

}  // namespace palpate
