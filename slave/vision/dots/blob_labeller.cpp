#include "slave/vision/dots/blob_labeller.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <utility>

#include <opencv2/core/hal/intrin.hpp>

#include "shared/geometry/index.h"

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

constexpr int kLane = 16;  // [-] [tuned: CentroidsOfEllipsesWithoutNoiseAreExact]

// Sixteen pixels to sixteen bits.
std::uint64_t Lane(const std::uint8_t* pixels, std::uint8_t threshold) noexcept {
  const cv::v_uint8x16 level = cv::v_load(pixels);
  return static_cast<std::uint64_t>(
      static_cast<std::uint16_t>(cv::v_signmask(level < cv::v_setall_u8(threshold))));
}

Blob BlobOfRun(int y, int begin, int end) noexcept {
  const std::int64_t n = end - begin, first = begin, last = end - 1;
  const auto squares = [](std::int64_t k) { return k * (k + 1) * (2 * k + 1) / 6; };
  Blob blob;
  blob.area = n;
  blob.x = n * (first + last) / 2;
  blob.y = n * y;
  blob.xx = squares(last) - squares(first - 1);
  blob.xy = blob.x * y;
  blob.yy = n * y * y;
  blob.left = begin, blob.right = end - 1;
  blob.top = blob.bottom = y;
  return blob;
}

void Add(const Blob& part, Blob& whole) noexcept {
  whole.area += part.area;
  whole.x += part.x, whole.y += part.y;
  whole.xx += part.xx, whole.xy += part.xy, whole.yy += part.yy;
  whole.left = std::min(whole.left, part.left);
  whole.right = std::max(whole.right, part.right);
  whole.top = std::min(whole.top, part.top);
  whole.bottom = std::max(whole.bottom, part.bottom);
}

}  // namespace

bool ThresholdMap::Fit(const cv::Mat& image, int min_contrast) {
  columns_ = (image.cols + kTile - 1) / kTile;
  rows_ = (image.rows + kTile - 1) / kTile;
  const auto tiles = Index(columns_) * Index(rows_);
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
          const auto tile = Index(b * columns_ + a);
          darkest = std::min<int>(darkest, darkest_[tile]);
          lightest = std::max<int>(lightest, lightest_[tile]);
        }
      }
      if (lightest - darkest < min_contrast) continue;
      const int tile = j * columns_ + i;
      levels_[Index(tile)] = static_cast<std::uint8_t>((darkest + lightest + 1) / 2);
      known_[Index(tile)] = 1;
      front_.push_back(tile);
    }
  }
  if (front_.empty()) return false;
  Spread();
  return true;
}

void ThresholdMap::FindExtremes(const cv::Mat& image) {
  column_darkest_.resize(Index(image.cols));
  column_lightest_.resize(Index(image.cols));
  for (int j = 0; j < rows_; ++j) {
    std::fill(column_darkest_.begin(), column_darkest_.end(), std::uint8_t{255});
    std::fill(column_lightest_.begin(), column_lightest_.end(), std::uint8_t{0});
    for (int y = j * kTile; y < std::min(image.rows, (j + 1) * kTile); ++y) {
      Extend(image.ptr<std::uint8_t>(y), image.cols, column_darkest_.data(),
             column_lightest_.data());
    }
    for (int i = 0; i < columns_; ++i) {
      const int begin = i * kTile, end = std::min(image.cols, begin + kTile);
      const auto tile = Index(j * columns_ + i);
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
          const auto other = Index(b * columns_ + a);
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
          const auto other = Index(b * columns_ + a);
          if (known_[other] == 1) sum += levels_[other], ++count;
        }
      }
      levels_[Index(tile)] = static_cast<std::uint8_t>(sum / std::max(1, count));
    }
    for (const int tile : next_front_) known_[Index(tile)] = 1;
    std::swap(front_, next_front_);
  }
}

void DarkBits(const std::uint8_t* row, int width, const std::uint8_t* thresholds,
              std::uint64_t* bits) noexcept {
  const int whole = width / kLane;
  std::fill_n(bits, (width + 63) / 64, std::uint64_t{0});
  for (int lane = 0; lane < whole; ++lane) {
    bits[lane / 4] |= Lane(row + lane * kLane, thresholds[lane]) << (lane % 4 * kLane);
  }
  for (int x = whole * kLane; x < width; ++x) {
    if (row[x] < thresholds[whole]) bits[x / 64] |= std::uint64_t{1} << (x % 64);
  }
}

void BlobLabeller::Begin(int width) {
  width_ = width;
  parents_.reserve(kMaxRegions);
  blobs_.reserve(kMaxRegions);
  above_.reserve(Index(width) / 2 + 1);
  here_.reserve(Index(width) / 2 + 1);
  parents_.clear();
  blobs_.clear();
  above_.clear();
  here_.clear();
}

void BlobLabeller::AddRow(int y, const std::uint64_t* bits, bool inverted) noexcept {
  std::swap(above_, here_);
  here_.clear();
  next_above_ = 0;
  const int words = (width_ + 63) / 64;
  std::uint64_t before = 0;  // the last pixel of the word before
  int begin = 0;
  bool open = false;
  for (int i = 0; i < words; ++i) {
    std::uint64_t word = inverted ? ~bits[i] : bits[i];
    const int beyond = 64 * (i + 1) - width_;
    if (beyond > 0) word &= ~std::uint64_t{0} >> beyond;
    for (std::uint64_t changes = word ^ (word << 1 | before); changes != 0;
         changes &= changes - 1) {
      const int x = 64 * i + std::countr_zero(changes);
      if (open) AddRun(y, begin, x);
      begin = x;
      open = !open;
    }
    before = word >> 63;
  }
  if (open) AddRun(y, begin, width_);
}

// Joins what touches it in the row above; runs of a row come from left to right.
void BlobLabeller::AddRun(int y, int begin, int end) noexcept {
  while (next_above_ < above_.size() && above_[next_above_].end <= begin) ++next_above_;
  int label = -1;
  for (std::size_t k = next_above_; k < above_.size() && above_[k].begin < end; ++k) {
    const int touched = Root(above_[k].label);
    label = label < 0 ? touched : Join(label, touched);
  }
  const Blob run = BlobOfRun(y, begin, end);
  if (label < 0) {
    if (blobs_.size() == kMaxRegions) return;
    label = static_cast<int>(blobs_.size());
    parents_.push_back(label);
    blobs_.push_back(run);
  } else {
    Add(run, blobs_[Index(label)]);
  }
  here_.push_back({begin, end, label});
}

int BlobLabeller::Root(int label) noexcept {
  while (parents_[Index(label)] != label) {
    int& parent = parents_[Index(label)];
    parent = parents_[Index(parent)];  // halves the path
    label = parent;
  }
  return label;
}

int BlobLabeller::Join(int a, int b) noexcept {
  if (a == b) return a;
  if (b < a) std::swap(a, b);
  parents_[Index(b)] = a;
  Add(blobs_[Index(b)], blobs_[Index(a)]);
  blobs_[Index(b)].area = 0;
  return a;
}

const std::vector<Blob>& BlobLabeller::Finish() noexcept {
  std::erase_if(blobs_, [](const Blob& blob) { return blob.area == 0; });
  return blobs_;
}

}  // namespace palpate
