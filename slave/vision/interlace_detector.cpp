#include "slave/vision/interlace_detector.h"

#include <cmath>
#include <cstdlib>

namespace palpate {
namespace {

// What moving the rows must leave of the differences to be believed: noise alone leaves all, a comb
// among the noise of a usual camera less than half. [-] [tuned:
// RowsThatLieAsideAreToldWithTheirShift]
constexpr double kLeft = 0.7;
// By which more must be left by a shorter way: a mosaic of colours looks alike again and again. [-]
// [tuned: RowsThatLieAsideAreToldWithTheirShift]
constexpr double kClearly = 0.9;

}  // namespace

InterlaceDetector::InterlaceDetector(const cv::Mat& first) : format_(first) {
  window_.Resize(2 * kHalfSize, 2 * kHalfSize);
}

long InterlaceDetector::Apart(int shift) const noexcept {
  long sum = 0;
  for (int y = 1; y + 1 < window_.height; y += 2) {
    const std::int16_t *above = window_.Row(y - 1), *here = window_.Row(y) + shift,
                       *below = window_.Row(y + 1);
    for (int x = kMost; x < window_.width - kMost; ++x) {
      sum += std::abs(2 * here[x] - above[x] - below[x]);
    }
  }
  return sum;
}

int InterlaceDetector::Shift(const cv::Mat& image, const Eigen::Vector2d& p_I) noexcept {
  if (!format_.Fits(image) || !p_I.allFinite()) return 0;
  if ((p_I.array().abs() > 1e6).any()) return 0;
  const cv::Point middle(
      static_cast<int>(std::lround(p_I.x())),
      static_cast<int>(std::lround(p_I.y())) / 2 * 2);  // begins with an even row
  const cv::Rect around(middle.x - kHalfSize, middle.y - kHalfSize, 2 * kHalfSize, 2 * kHalfSize);
  const cv::Rect window = around & cv::Rect(0, 0, image.cols, image.rows);
  if (window.width <= 4 * kMost || window.height < kMost) return 0;
  format_.Read(image, window, window_);
  const long in_place = Apart(0);
  long least = in_place;
  int best = 0;
  for (int way = 1; way <= kMost; ++way) {
    for (const int shift : {-way, way}) {
      const long apart = Apart(shift);
      if (static_cast<double>(apart) < kClearly * static_cast<double>(least)) {
        least = apart;
        best = shift;
      }
    }
  }
  const bool is_told = static_cast<double>(least) < kLeft * static_cast<double>(in_place);
  return is_told ? best : 0;
}

}  // namespace palpate
