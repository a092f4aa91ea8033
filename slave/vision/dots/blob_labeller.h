// Regions of an image that differ from their background: local threshold and connected regions.
#pragma once

#include <cstdint>
#include <vector>

#include <opencv2/core/mat.hpp>

namespace palpate {

// The grey level that separates dots from their background, tile by tile, independent of the
// illumination across the image. Half way between the darkest and the lightest level of a tile and
// its eight neighbours if these differ enough; elsewhere (inside a large dot, on a plain
// background) that of the nearest such tiles.
class ThresholdMap {
 public:
  static constexpr int kTile = 16;  // [px] [tuned: CentroidsOfEllipsesWithoutNoiseAreExact]

  // `image`: 8 bit grey. `min_contrast`: least levels between dot and background. False: no part of
  // the image has this contrast. Allocates only when the size grows.
  bool Fit(const cv::Mat& image, int min_contrast);
  // One level per tile of the tile row that contains image row `y`.
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

// Connected regions of a binary image, from the runs of its rows. For each region the sums over its
// pixels, and its bounding box (last row and column included).
struct Blob {
  std::int64_t area = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  int left = 0, right = 0, top = 0, bottom = 0;
};

// Which of a row's pixels are darker than their tile's threshold: bit x of the words. `thresholds`:
// one per 16 pixels. `bits`: (width + 63) / 64 words; bits beyond the row are zero.
void DarkBits(const std::uint8_t* row, int width, const std::uint8_t* thresholds,
              std::uint64_t* bits) noexcept;

// Rows are passed from top to bottom; pixels that share an edge are connected.
class BlobLabeller {
 public:
  // In an image full of speckles, regions beyond this count are ignored.
  static constexpr std::size_t kMaxRegions = 1 << 15;

  // Allocates only when the width grows.
  void Begin(int width);
  // `bits` as from DarkBits; `inverted`: the zeros are meant.
  void AddRow(int y, const std::uint64_t* bits, bool inverted) noexcept;
  // Every region once, in no order; valid until the next Begin.
  const std::vector<Blob>& Finish() noexcept;

 private:
  struct Run {
    int begin, end, label;
  };
  void AddRun(int y, int begin, int end) noexcept;
  int Root(int label) noexcept;
  int Join(int a, int b) noexcept;

  int width_ = 0;
  std::vector<Run> above_, here_;
  std::size_t next_above_ = 0;
  std::vector<int> parents_;  // per label
  std::vector<Blob> blobs_;   // per label; joined ones are empty
};

}  // namespace palpate
