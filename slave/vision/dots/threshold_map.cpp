#include "slave/vision/dots/threshold_map.h"

#include <algorithm>
#include <cstddef>

namespace palpate {
namespace {

// The compiler makes byte-wise minima and maxima of this.
void Extend(const std::uint8_t* __restrict row, int width, std::uint8_t* __restrict darkest,
            std::uint8_t* __restrict lightest) {
  for (int x = 0; x < width; ++x) {
    darkest[x] = std::min(darkest[x], row[x]);
    lightest[x] = std::max(lightest[x], row[x]);
  }
}

}  // namespace

bool ThresholdMap::Fit(const cv::Mat& image, int min_contrast) {
  columns_ = (image.cols + kTile - 1) / kTile;
  rows_ = (image.rows + kTile - 1) / kTile;
  const auto tiles = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  darkest_.resize(tiles);
  lightest_.resize(tiles);
  levels_.assign(tiles, 0);
  known_.assign(tiles, 0);
  front_.clear();
  front_.reserve(tiles);
  next_front_.reserve(tiles);
  FindExtremes(image);
  for (int j = 0; j < rows_; ++j) {
    for (int i = 0; i < columns_; ++i) {
      int darkest = 255, lightest = 0;
      for (int b = std::max(0, j - 1); b <= std::min(rows_ - 1, j + 1); ++b) {
        for (int a = std::max(0, i - 1); a <= std::min(columns_ - 1, i + 1); ++a) {
          const auto tile = static_cast<std::size_t>(b * columns_ + a);
          darkest = std::min<int>(darkest, darkest_[tile]);
          lightest = std::max<int>(lightest, lightest_[tile]);
        }
      }
      if (lightest - darkest < min_contrast) continue;
      const int tile = j * columns_ + i;
      levels_[static_cast<std::size_t>(tile)] =
          static_cast<std::uint8_t>((darkest + lightest + 1) / 2);
      known_[static_cast<std::size_t>(tile)] = 1;
      front_.push_back(tile);
    }
  }
  if (front_.empty()) return false;
  Spread();
  return true;
}

void ThresholdMap::FindExtremes(const cv::Mat& image) {
  column_darkest_.resize(static_cast<std::size_t>(image.cols));
  column_lightest_.resize(static_cast<std::size_t>(image.cols));
  for (int j = 0; j < rows_; ++j) {
    std::fill(column_darkest_.begin(), column_darkest_.end(), std::uint8_t{255});
    std::fill(column_lightest_.begin(), column_lightest_.end(), std::uint8_t{0});
    for (int y = j * kTile; y < std::min(image.rows, (j + 1) * kTile); ++y) {
      Extend(image.ptr<std::uint8_t>(y), image.cols, column_darkest_.data(),
             column_lightest_.data());
    }
    for (int i = 0; i < columns_; ++i) {
      const int begin = i * kTile, end = std::min(image.cols, begin + kTile);
      const auto tile = static_cast<std::size_t>(j * columns_ + i);
      darkest_[tile] =
          *std::min_element(column_darkest_.data() + begin, column_darkest_.data() + end);
      lightest_[tile] =
          *std::max_element(column_lightest_.data() + begin, column_lightest_.data() + end);
    }
  }
}

// Wave by wave: a tile without a level takes the mean of the neighbours that had one before.
void ThresholdMap::Spread() {
  constexpr std::uint8_t kNew = 2;
  while (!front_.empty()) {
    next_front_.clear();
    for (const int tile : front_) {
      const int i = tile % columns_, j = tile / columns_;
      for (int b = std::max(0, j - 1); b <= std::min(rows_ - 1, j + 1); ++b) {
        for (int a = std::max(0, i - 1); a <= std::min(columns_ - 1, i + 1); ++a) {
          const auto other = static_cast<std::size_t>(b * columns_ + a);
          if (known_[other] != 0) continue;
          known_[other] = kNew;
          next_front_.push_back(b * columns_ + a);
        }
      }
    }
    for (const int tile : next_front_) {
      const int i = tile % columns_, j = tile / columns_;
      int sum = 0, count = 0;
      for (int b = std::max(0, j - 1); b <= std::min(rows_ - 1, j + 1); ++b) {
        for (int a = std::max(0, i - 1); a <= std::min(columns_ - 1, i + 1); ++a) {
          const auto other = static_cast<std::size_t>(b * columns_ + a);
          if (known_[other] == 1) sum += levels_[other], ++count;
        }
      }
      levels_[static_cast<std::size_t>(tile)] = static_cast<std::uint8_t>(sum / std::max(1, count));
    }
    for (const int tile : next_front_) known_[static_cast<std::size_t>(tile)] = 1;
    std::swap(front_, next_front_);
  }
}

}  // namespace palpate
