// One eye on an array of dots: finds dots in its pictures, and each dot of the array keeps its
// identity from picture to picture.
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

// Where a dot is expected, and what it looked like.
struct ExpectedDot {
  Eigen::Vector2d place{0, 0};   // [px]; not finite: not looked for
  Eigen::Vector2d extent{8, 8};  // half its width and height [px]
  double area = 0;               // [px^2]; 0: any
  double search = 8;             // how far from `place` it may be, along each axis [px]
};

struct SightedDot {
  bool seen = false;
  Dot dot;
};

// Finds dots in 8-bit pictures: all of them, or those near predicted places. Not thread-safe.
// Allocates only when pictures grow.
class DotFinder {
 public:
  struct Params {
    DotTone tone = DotTone::kDark;
    DotShapeLimits limits;
    std::size_t most = 1024;  // no more dots than this are reported
  };
  // Throws std::invalid_argument naming the parameter.
  explicit DotFinder(const Params& params);

  // Every dot of the picture. False, and no dots: not 8-bit grey, empty, or out of memory. Dots cut
  // by the picture's edge are left out.
  bool Find(const cv::Mat& image, std::vector<Dot>* dots) noexcept;
  // One answer per expected dot: the nearest to its place with an area within a factor of 2.
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

// Follows an array from picture to picture. Not thread-safe. Allocates in the first pictures only.
class DotTracker {
 public:
  // kNear looks about the last places and searches the whole picture when dots are missing (every
  // eighth picture, at once when many are lost); kWhole searches it every time.
  enum class Search { kNear, kWhole };
  struct Params {
    DotFinder::Params finder;
    bool any_tone = true;  // take the tone that shows the array, whatever `finder` says
    DotArray::Params array;
    Search search = Search::kNear;
  };
  // Throws as DotFinder and DotArray do.
  DotTracker(std::vector<Eigen::Vector2d> layout, const Params& params);

  // About where the array is in the first picture, a place per dot [px]; tells the ways apart in
  // which a symmetric array can be seen.
  void Hint(std::vector<Eigen::Vector2d> places);
  // Looks at the next picture. False: the array is not there, or the picture is no 8-bit grey one
  // with something in it.
  bool Process(const cv::Mat& image) noexcept;
  // Forgets all but the places: the next picture is matched anew.
  void Lose() noexcept { found_ = false; }

  // One per dot of the layout; where not seen, `dot.centre` is where it should be, from its
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
  std::vector<double> areas_;            // last seen
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
