// Windows of texture seen by two cameras: points of a surface in space (paper C, 5.2).
//
// The left camera's first picture gives the templates; both cameras look for the same ones, so that
// the two places belong to one point. A pair counts where the two rays meet, at any distance, where
// each picture leads to the other, and where nothing else along the line looks alike.
#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/scene/scene.h"
#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"
#include "slave/vision/texture/epipolar_line.h"
#include "slave/vision/texture/ssd_tracker.h"

namespace palpate {

struct StereoTextureOptions {
  std::vector<Eigen::Vector2d> at;  // windows in the first left picture [px]; empty: chosen
  int count = 31;                   // of chosen windows, at most; 1 to 10000
  double sigma = 0.1;               // of a place in a picture, at least [px], > 0
  double most_miss = 1.5;           // of the two rays, in pixels of the left picture [px], > 0
  SsdOptions ssd;
  EpipolarOptions search;

  static StereoTextureOptions From(const PointTracking& points);
};

class StereoTexture {
 public:
  // Throws std::invalid_argument naming the option and what is accepted.
  StereoTexture(const StereoRig& rig, const Eigen::Isometry3d& X_SL,
                const StereoTextureOptions& options);
  ~StereoTexture();

  // The first pair on which at least one window is seen by both cameras starts the tracking and is
  // the rest frame (a window seen by both only later rests where it was then seen first). Pictures
  // that cannot be used (not 8 bit, of another size) leave all points unseen, and `found` false.
  // noexcept but for the start, which allocates and may throw std::invalid_argument: pictures too
  // small for the pyramid. After that it has not started.
  const SurfaceObservation& Process(const cv::Mat& left, const cv::Mat& right,
                                    std::uint64_t sequence, Time sensed_at);

  [[nodiscard]] bool started() const { return left_ != nullptr; }
  // Per window, in the order of the points' ids; empty before the start.
  [[nodiscard]] const std::vector<TrackedWindow>& left_windows() const;
  [[nodiscard]] const std::vector<TrackedWindow>& right_windows() const;

 private:
  bool Start(const cv::Mat& left, const cv::Mat& right);
  void Pair() noexcept;
  void MeetAgain(std::size_t i) noexcept;
  [[nodiscard]] bool LeadsBack(std::size_t i, bool to_left) noexcept;
  bool Locate(std::size_t i) noexcept;

  StereoRig rig_;
  Eigen::Isometry3d X_RL_, X_LR_, X_SL_;
  StereoTextureOptions options_;
  std::unique_ptr<SsdTracker> left_, right_;
  std::unique_ptr<WindowTemplate> back_;  // cut anew for every way back
  int level_ = 0;  // of the pyramid, on which one camera searches the other's
  std::vector<bool> has_rest_;
  std::size_t next_search_ = 0;  // windows that one camera lost take turns
  SurfaceObservation observation_;
};

}  // namespace palpate
