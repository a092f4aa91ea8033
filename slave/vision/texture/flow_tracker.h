// Follows windows of texture through the images of one camera (paper C, 5.2).
//
// OpenCV's pyramidal optical flow gives the motion since the last image. It must lead back to where
// it began. The window of the first image is then aligned at that position, so that positions do
// not drift. A lost window moves with the others and is searched by the flow from the first image.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "slave/vision/patch_aligner.h"

namespace palpate {

struct FlowOptions {
  int window = 31;               // edge [px], odd, 9 to 255
  double min_correlation = 0.8;  // of a window that is still the same, (0, 1)
  // Smallest correlation at which a lost window is accepted again, (0, 1).
  double refind_correlation = 0.9;
  double max_return_miss = 0.5;  // distance of the flow there and back [px], > 0
};

struct TrackedWindow {
  bool has_texture = false;  // in the first image; otherwise the window is never seen
  bool seen = false;
  PatchWarp warp;                                        // the last one found
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of warp.p [px^2]
};

// One thread.
class FlowTracker {
 public:
  static constexpr int kCoarseLevel = 1;  // of coarse_template() and coarse_image(): half the size

  // `at`: centres in the first image [px]. Throws std::invalid_argument: options, or an image that
  // is not 8 bit grey or BGR, or smaller than 32 px.
  FlowTracker(const cv::Mat& first, const std::vector<Eigen::Vector2d>& at,
              const FlowOptions& options);

  // `image` has the size of the first one.
  const std::vector<TrackedWindow>& Track(const cv::Mat& image);
  [[nodiscard]] const std::vector<TrackedWindow>& windows() const { return windows_; }

  // Makes a tracker with the same templates for another camera, whose first image is `image`. All
  // windows are lost until Place() sets their positions, and lost ones are not searched, because
  // the caller knows the epipolar geometry. Throws std::invalid_argument as the constructor.
  [[nodiscard]] FlowTracker InOtherCamera(const cv::Mat& image) const;
  // Aligns window `i` near `start` in the last image and tracks it from there; false: not found.
  bool Place(std::size_t i, const PatchWarp& start) noexcept;
  // Overrides the result: window `i` was not found.
  void Lose(std::size_t i) noexcept { windows_[i].seen = false; }

  [[nodiscard]] PatchAligner& coarse_template(std::size_t i) noexcept {
    return templates_[i].coarse;
  }
  [[nodiscard]] const cv::Mat& coarse_image() const { return now_.coarse; }

 private:
  struct Image {
    cv::Mat grey, coarse;
    std::vector<cv::Mat> pyramid;  // of the optical flow
  };
  struct Templates {
    Eigen::Vector2d centre;  // in the first image [px]
    PatchAligner fine, coarse;
  };
  struct Flow {
    std::vector<std::size_t> windows;
    std::vector<cv::Point2f> from, to;  // to: the guess, then the result
    std::vector<bool> returns;
  };

  static Image Read(const cv::Mat& image);
  void Follow(const Image& before, Flow* flow) const;
  Eigen::Vector2d FollowSeen(const Image& before);
  void FindLost(const Eigen::Vector2d& motion);
  bool Align(std::size_t i, const PatchWarp& start, double min_correlation) noexcept;

  FlowOptions options_;
  Image first_, now_;
  bool finds_lost_ = true;
  std::vector<TrackedWindow> windows_;
  std::vector<Templates> templates_;
};

// Automatic selection of windows: centres [px] of at most `count` windows of `edge` px whose
// structure tensor (sum of grad grad^T over the window) has the largest smaller eigenvalues: J. Shi
// and C. Tomasi, CVPR 1994. At least `apart` from each other, with a window inside the image; best
// first. Empty: no texture, or an unusable image (not 8 bit, neither grey nor BGR).
std::vector<Eigen::Vector2d> ChooseWindows(const cv::Mat& image, int count, int edge, double apart);

}  // namespace palpate
