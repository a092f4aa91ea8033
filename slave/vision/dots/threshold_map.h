// The grey level that parts dots from their ground, tile by tile: light that falls across the
// picture does not move it.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

// Half way between the darkest and the lightest of a tile and its eight neighbours where these
// differ enough; elsewhere (inside a large dot, on plain ground) what the nearest such tiles have.
class ThresholdMap {
 public:
  static constexpr int kTile = 16;  // [px]

  // `image`: 8 bit grey. `min_contrast`: levels between dot and ground that count. False: nowhere
  // in the picture is there so much. Allocates only when the size grows.
  bool Fit(const cv::Mat& image, int min_contrast);
  // One level per tile of the tile row in which picture row `y` lies.
  [[nodiscard]] const std::uint8_t* Row(int y) const {
    return levels_.data() + static_cast<std::ptrdiff_t>(y / kTile) * columns_;
  }
  [[nodiscard]] int At(int x, int y) const { return Row(y)[x / kTile]; }

 private:
  void FindExtremes(const cv::Mat& image);
  void Spread();

  int columns_ = 0, rows_ = 0;
  std::vector<std::uint8_t> darkest_, lightest_;                // rows x columns
  std::vector<std::uint8_t> column_darkest_, column_lightest_;  // of one row of tiles
  std::vector<std::uint8_t> levels_;                            // rows x columns
  std::vector<std::uint8_t> known_;                             // rows x columns
  std::vector<int> front_, next_front_;                         // tiles with a level, at the edge
};

}  // namespace palpate
