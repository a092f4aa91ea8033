// Tracks an array of dots with one camera: keeps each dot's identity from image to image.
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/dots/dot.h"
#include "slave/vision/dots/dot_array.h"
#include "slave/vision/dots/dot_finder.h"

namespace palpate {

struct SightedDot {
  bool seen = false;
  Dot dot;
};

// DotTracker is not thread-safe.
class DotTracker {
 public:
  struct Params {
    DotFinder::Params finder;
    bool any_tone = true;  // use the polarity that shows the array, independent of `finder`
    // Fraction of the array that must be visible at first; later half of this.
    double min_seen = 0.6;
  };
  // `projected`: positions of the layout at rest in the image [px], accurate to about half a
  // spacing. Throws as DotFinder and DotArray do.
  DotTracker(std::vector<Eigen::Vector2d> layout, std::vector<Eigen::Vector2d> projected,
             const Params& params);

  // Processes the next image. False: the array was not found, or the image is not 8-bit grey or is
  // empty.
  bool Process(const cv::Mat& image) noexcept;
  // The next image is matched without the last one.
  void Lose() noexcept { found_ = false; }

  // Returns one entry per dot of the layout. If a dot is not visible, `dot.centre` is the position
  // expected from its neighbours, and may be NaN.
  [[nodiscard]] const std::vector<SightedDot>& dots() const { return dots_; }
  [[nodiscard]] int seen() const { return seen_; }
  [[nodiscard]] bool found() const { return found_; }
  [[nodiscard]] const DotArray& array() const { return array_; }

 private:
  bool SearchFirst(const cv::Mat& image);
  bool Search(std::span<const Eigen::Vector2d> places, double min_seen);
  void ExpectTheMissing();

  Params params_;
  DotFinder finder_;
  DotArray array_;
  std::vector<Eigen::Vector2d> projected_;  // at rest [px]
  std::vector<Eigen::Vector2d> places_;     // in the last image [px]
  std::vector<double> areas_;               // area when last seen [px^2]; 0: never seen
  std::vector<SightedDot> dots_;
  int seen_ = 0;
  bool found_ = false;
  std::vector<Dot> all_;    // dots of the present image
  std::vector<int> picks_;  // index in all_ per dot of the array
};

}  // namespace palpate
