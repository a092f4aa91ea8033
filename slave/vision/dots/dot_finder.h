// Detects dots in images: regions that differ from the ground around them, each measured to a small
// part of a pixel.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "slave/vision/dots/dot.h"

namespace palpate {

// DotFinder is not thread-safe.
class DotFinder {
 public:
  struct Params {
    DotTone tone = DotTone::kDark;
    DotShapeLimits limits;
    std::size_t most = 1024;  // largest number of reported dots
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DotFinder(const Params& params);

  // Finds all dots of an 8-bit grey image. Returns false and no dots for another type of image, or
  // out of memory. Dots cut by the image border are not used.
  bool Find(const cv::Mat& image, std::vector<Dot>* dots) noexcept;

  [[nodiscard]] const Params& params() const { return params_; }
  void set_tone(DotTone tone) { params_.tone = tone; }

 private:
  using Regions = std::vector<std::vector<cv::Point>>;  // outlines of the regions

  void Binarise(const cv::Mat& image);
  [[nodiscard]] bool MayBeDot(const cv::Rect& box, const cv::Size& image) const;
  [[nodiscard]] std::optional<Dot> Measure(const cv::Mat& image, const cv::Rect& box);

  Params params_;
  cv::Mat binary_, region_;
  Regions regions_, inner_;
};

}  // namespace palpate
