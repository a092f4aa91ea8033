// What a depth camera sees while nothing touches the surface, pixel by pixel.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

namespace palpate {

// A plane over the picture: one over the depth is linear in the rays' slopes, 1/z = m . (x, y, 1).
using InverseDepth = Eigen::Vector3d;  // [1/m]

// A square of pixels, named by its upper left one [px].
struct DepthCell {
  int column = 0, row = 0, edge = 0;
};

class RestDepth {
 public:
  // Depths are counted in fractions of the picture's unit.
  static constexpr int kFractions = 16;

  // Counts from `lowest` to `highest` are measurements. A pixel whose depths differ by more than
  // `flicker` counts has no rest depth, nor has one that half of the pictures do not see.
  RestDepth(int pictures, int lowest, int highest, double flicker);

  // One picture, CV_16U. False: it cannot be used (empty, another type or size than the first, no
  // measurement at all) and is not counted. Allocates at the first.
  bool Add(const cv::Mat& depth);
  [[nodiscard]] bool Fits(const cv::Mat& depth) const noexcept;
  [[nodiscard]] bool known() const { return taken_ >= pictures_; }
  void Reset() noexcept;

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  // Depths of a row of pixels at rest, in fractions of a count; 0: not known. After known().
  [[nodiscard]] const std::int32_t* row(int v) const {
    return rest_.data() + static_cast<std::ptrdiff_t>(v) * width_;
  }
  [[nodiscard]] bool IsMeasured(std::uint16_t count) const {
    return count >= lowest_ && count <= highest_;
  }

  // The plane through the rest depths of a cell inside the picture, those that stand out left out;
  // `unit` of a count [m]. nullopt: fewer than `least` pixels, or all about on a line.
  struct Pinhole {
    double fx, fy, cx, cy;  // [px]
  };
  [[nodiscard]] std::optional<InverseDepth> PlaneOf(const DepthCell& cell, int least,
                                                    const Pinhole& camera, double unit) const;

 private:
  void Finish();

  int pictures_, lowest_, highest_;
  double flicker_;
  int width_ = 0, height_ = 0, taken_ = 0;
  std::vector<std::int32_t> rest_;  // while taken: sums of counts
  std::vector<std::uint16_t> seen_, least_, most_;
};

}  // namespace palpate
