// Tracks an array of dots with one camera: detects dots in its images and keeps each dot's identity
// from image to image.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>

#include "slave/vision/dots/blob_labeller.h"
#include "slave/vision/dots/dot.h"
#include "slave/vision/dots/dot_array.h"

namespace palpate {

// Expected position and appearance of a dot.
struct ExpectedDot {
  Eigen::Vector2d place{0, 0};   // [px]; not finite: no search
  Eigen::Vector2d extent{8, 8};  // half its width and height [px]
  double area = 0;               // [px^2]; 0: any
  double search = 8;             // largest distance from `place` along each axis [px]
};

struct SightedDot {
  bool seen = false;
  Dot dot;
};

// Detects dots in 8-bit images: all of them, or those near predicted positions. Not thread-safe.
// Allocates only when images grow.
class DotFinder {
 public:
  struct Params {
    DotTone tone = DotTone::kDark;
    DotShapeLimits limits;
    std::size_t most = 1024;  // no more dots than this are reported
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DotFinder(const Params& params);

  // All dots of the image. False, and no dots: not 8-bit grey, empty, or out of memory. Dots cut by
  // the image border are not used.
  bool Find(const cv::Mat& image, std::vector<Dot>* dots) noexcept;
  // One result per expected dot: the nearest to its position with an area within a factor of 2.
  bool Track(const cv::Mat& image, const std::vector<ExpectedDot>& expected,
             std::vector<SightedDot>* sighted) noexcept;

  [[nodiscard]] const Params& params() const { return params_; }
  void set_tone(DotTone tone) { params_.tone = tone; }

 private:
  SightedDot Detect(const cv::Mat& image, const ExpectedDot& expected);

  Params params_;
  ThresholdMap thresholds_;
  BlobLabeller labeller_;
  std::vector<std::uint64_t> bits_;          // of one row
  std::vector<std::uint8_t> one_threshold_;  // the same for all of a window
};

// Tracks an array from image to image. Not thread-safe. Allocates in the first images only.
class DotTracker {
 public:
  // kNear searches near the last positions, and the whole image when dots are missing (every eighth
  // image, at once when many are lost); kWhole searches the whole image every time.
  enum class Search { kNear, kWhole };
  struct Params {
    DotFinder::Params finder;
    bool any_tone = true;  // use the polarity that shows the array, independent of `finder`
    DotArray::Params array;
    Search search = Search::kNear;
  };
  // Throws as DotFinder and DotArray do.
  DotTracker(std::vector<Eigen::Vector2d> layout, const Params& params);

  // Approximate positions in the first image, one per dot [px]; they select one of the orientations
  // of a symmetric array.
  void Hint(std::vector<Eigen::Vector2d> places);
  // Processes the next image. False: the array was not found, or the image is not 8-bit grey or is
  // empty.
  bool Process(const cv::Mat& image) noexcept;
  // Clears all but the positions: the next image is matched without them.
  void Lose() noexcept { found_ = false; }

  // One per dot of the layout; if not visible, `dot.centre` is the position expected from its
  // neighbours, and may be NaN.
  [[nodiscard]] const std::vector<SightedDot>& dots() const { return dots_; }
  [[nodiscard]] int seen() const { return seen_; }
  [[nodiscard]] bool found() const { return found_; }
  [[nodiscard]] const DotArray& array() const { return array_; }

 private:
  bool SearchFirst(const cv::Mat& image);
  void SearchNear(const cv::Mat& image);
  void SearchEverywhere(const cv::Mat& image);
  bool Rematch();
  void Take(std::span<const int> picks);
  void Accept(std::size_t k, const Dot& dot);
  void DropStrays();
  void ExpectTheMissing();
  void Start();

  Params params_;
  DotFinder finder_;
  DotArray array_;
  bool found_ = false;
  int seen_ = 0, last_seen_ = 0;
  int pictures_missing_ = 0;             // in a row, with a dot missing
  std::vector<Eigen::Vector2d> places_;  // last known, or hinted; empty: nothing known
  std::vector<Eigen::Vector2d> start_;   // where the dots were when the array was matched
  std::vector<double> areas_;            // last visible position
  std::vector<SightedDot> dots_;
  // Work space.
  std::vector<Dot> all_;
  std::vector<int> picks_;
  std::vector<ExpectedDot> expected_;
  std::vector<SightedDot> dots_sighted_;
  std::vector<Eigen::Vector2d> now_;
  std::vector<char> flags_, strays_;
};

}  // namespace palpate
