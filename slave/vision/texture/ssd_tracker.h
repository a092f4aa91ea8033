// Follows windows of texture through the images of one camera (paper C, 5.2).
//
// The template of a window is always that of the first image, searched from coarse to fine, so that
// its position does not drift. Each match must be confirmed by tracking back to the previous image.
// A lost window is searched around its last position, in a radius that grows with every image.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/patch_aligner.h"
#include "slave/vision/texture/image_pyramid.h"

namespace palpate {

struct SsdOptions {
  int window = 31;               // edge [px], odd, 9 to 255
  int levels = 3;                // of the pyramid, 1 to 6
  double min_correlation = 0.8;  // of a window that is still the same, (0, 1)
  // Smallest score at which a lost window is accepted again, (0, 1).
  double refind_correlation = 0.9;
  double max_return_miss =
      0.5;                 // distance after tracking back, in pixels of the previous image [px]
  int search_radius = 96;  // largest search radius for lost windows [px]
};

enum class WindowState : std::uint8_t {
  kTracked,
  kNoTexture,  // the first image has no structure there, or the window leaves it
  kLost,       // covered, outside the image, or changed
  kBadImage,   // not of the first image's size and type
};

struct TrackedWindow {
  WindowState state = WindowState::kLost;
  PatchWarp warp;                                        // the last one found
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // of warp.p [px^2]
  [[nodiscard]] bool seen() const { return state == WindowState::kTracked; }
};

class SsdTracker {
 public:
  // `at`: centres in the first image [px]. Throws std::invalid_argument: options, or an image that
  // is not 8 bit grey or BGR. A window without texture stays kNoTexture.
  SsdTracker(const cv::Mat& first, const std::vector<Eigen::Vector2d>& at,
             const SsdOptions& options);

  // Real-time safe. One thread.
  const std::vector<TrackedWindow>& Track(const cv::Mat& image) noexcept;
  [[nodiscard]] const std::vector<TrackedWindow>& windows() const { return windows_; }

  // Makes a tracker with the same templates for another camera, whose first image is `image`. All
  // windows are lost until Place() sets their positions, and lost ones are not searched, because
  // the caller knows the epipolar geometry. Throws std::invalid_argument as the constructor.
  [[nodiscard]] SsdTracker InOtherCamera(const cv::Mat& image) const;
  // Searches window `i` near `start` in the last image and tracks it from there; false: not found.
  // Real-time safe.
  bool Place(std::size_t i, const PatchWarp& start) noexcept;
  // Overrides the result: window `i` was not found. Real-time safe.
  void Lose(std::size_t i) noexcept;

  // Returns the window `i` in the first image on a level, 0 <= level < image().levels().
  [[nodiscard]] PatchAligner& Template(std::size_t i, int level) noexcept {
    return memories_[i].first[static_cast<std::size_t>(level)];
  }
  [[nodiscard]] const ImagePyramid& image() const { return now_; }

 private:
  using Templates = std::vector<PatchAligner>;  // one per level, fine first
  struct Memory {
    Templates first;
    Eigen::Vector2d velocity{0, 0};  // [px/image]
    int lost_for = 0;                // images
  };

  bool Cut(Templates& templates, const PatchWarp& warp) noexcept;
  static PatchWarp Coarse(Templates& templates, const ImagePyramid& image, const PatchWarp& start,
                          int top) noexcept;
  static PatchWarp Search(Templates& templates, const ImagePyramid& image, const PatchWarp& start,
                          int level, int radius) noexcept;
  static PatchAligner::Match Descend(Templates& templates, const ImagePyramid& image,
                                     const PatchWarp& start, int top) noexcept;
  [[nodiscard]] static bool Found(const PatchAligner::Match& match, double least) noexcept;
  bool Follow(TrackedWindow& window, Memory& memory) noexcept;
  bool ReturnsToStart(const PatchWarp& now, const PatchWarp& before) noexcept;
  bool Refind(TrackedWindow& window, Memory& memory) noexcept;
  static void Accept(TrackedWindow& window, const PatchAligner::Match& match) noexcept;

  SsdOptions options_;
  ImagePyramid now_, before_;
  std::vector<TrackedWindow> windows_;
  std::vector<Memory> memories_;
  Templates back_;               // cut again for every tracking back
  std::size_t next_search_ = 0;  // index of the next lost window to search
};

}  // namespace palpate
