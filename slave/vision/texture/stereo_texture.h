// Windows of texture seen by two cameras: points of a surface in space (paper C, 5.2).
//
// The templates are from the left camera's first image. They are searched in both cameras, so that
// both positions belong to one point. A pair is accepted if the two rays meet, at any distance, if
// the match is consistent in both directions, and if no other position along the line is similar.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"
#include "slave/vision/texture/epipolar_line.h"
#include "slave/vision/texture/flow_tracker.h"

namespace palpate {

struct StereoTextureOptions {
  std::vector<Eigen::Vector2d>
      at;                 // windows in the first left image [px]; empty: selected automatically
  int count = 31;         // of chosen windows, at most; 1 to 10000
  double sigma = 0.1;     // smallest sigma of a position in an image [px], > 0
  double max_miss = 1.5;  // distance of the two rays, in pixels of the left image [px], > 0
  FlowOptions flow;
  EpipolarOptions search;

  static StereoTextureOptions From(const PointTracking& points);
};

class StereoTexture {
 public:
  // Throws std::invalid_argument naming the option and what is accepted.
  StereoTexture(const StereoRig& rig, const Eigen::Isometry3d& X_SL,
                const StereoTextureOptions& options);
  ~StereoTexture();

  // The first pair with at least one window visible to both cameras starts the tracking and defines
  // the rest shape (a window that both see only later is at rest at its first position). Unusable
  // images (not 8 bit, of another size) give no visible points, and `found` false. Throws
  // std::invalid_argument at the start: images too small. Then it has not started.
  const SurfaceObservation& Process(const cv::Mat& left, const cv::Mat& right);

  [[nodiscard]] bool started() const { return left_ != nullptr; }
  // Per window, in the order of the points' ids; empty before the start.
  [[nodiscard]] const std::vector<TrackedWindow>& left_windows() const;

 private:
  bool Start(const cv::Mat& left, const cv::Mat& right);
  void Pair() noexcept;
  void RelocateLostSide(std::size_t i) noexcept;
  [[nodiscard]] bool ReturnsToStart(std::size_t i, bool to_left) noexcept;
  bool Locate(std::size_t i) noexcept;

  StereoRig rig_;
  Eigen::Isometry3d X_RL_, X_LR_, X_SL_;
  StereoTextureOptions options_;
  std::unique_ptr<FlowTracker> left_, right_;
  std::unique_ptr<PatchAligner> back_;  // cut again for every search back
  std::vector<bool> has_rest_;
  std::size_t next_search_ = 0;  // index of the next window that one camera lost
  SurfaceObservation observation_;
};

}  // namespace palpate
