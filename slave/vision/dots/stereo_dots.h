// An array of dots seen by a stereo pair: position of each dot in space and its displacement from
// rest.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "slave/vision/dots/dot_tracker.h"
#include "slave/vision/stereo/rig.h"
#include "slave/vision/stereo/surface_points.h"

namespace palpate {

// StereoDots is not thread-safe.
class StereoDots {
 public:
  struct Params {
    StereoRig rig;
    Eigen::Isometry3d X_SL = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d X_SO =
        Eigen::Isometry3d::Identity();    // pose at rest, to about half a spacing of the dots
    std::vector<Eigen::Vector2d> layout;  // of the dots, frame O [m]
    double dot_radius = 0.002;            // [m]
    double sigma_px = 0.1;  // smallest sigma of a dot's position in an image, per axis [px]
    int rest_images = 10;   // the rest frame is their mean
    double miss_px = 3;     // largest distance of the two rays of a dot [px]
    DotFinder::Params finder;
  };
  // Throws std::invalid_argument naming the parameter: a lens without focal length or size, no
  // baseline, the array not in view of both cameras, parameters that DotTracker rejects.
  explicit StereoDots(const Params& params);

  // Processes one pair: 8-bit grey, of the lenses' sizes. One point per dot, in the order of the
  // layout. `found` is false while the rest shape is measured, if the array is not in both images,
  // if its size differs from the layout, and for unusable images. A dot that was not visible while
  // the rest shape was measured is never visible. Valid until the next call.
  const SurfaceObservation& Observe(const cv::Mat& left, const cv::Mat& right) noexcept;

  [[nodiscard]] bool at_rest_known() const { return rest_taken_ >= params_.rest_images; }
  [[nodiscard]] const DotTracker& left() const { return trackers_[0]; }

 private:
  bool Locate();
  [[nodiscard]] bool SizeFits() noexcept;
  [[nodiscard]] Eigen::Vector3d Normal(std::size_t k) const noexcept;
  [[nodiscard]] std::optional<Triangulated> Place(std::size_t k,
                                                  const Eigen::Vector3d& n_L) const noexcept;
  void TakeRest() noexcept;
  void CompareRest() noexcept;

  Params params_;
  std::array<DotTracker, 2> trackers_;
  SurfaceObservation observation_;
  int rest_taken_ = 0;
  // Size of the array relative to the layout: present, and summed over the rest images.
  double size_ = 1, rest_sizes_ = 0;
  std::vector<int> rest_counts_;            // per dot
  std::vector<Eigen::Vector3d> rest_sums_;  // per dot, frame S [m]
  std::vector<std::optional<Triangulated>> raw_, located_;
  std::vector<double> ratios_;
};

}  // namespace palpate
