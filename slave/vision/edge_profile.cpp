#include "slave/vision/edge_profile.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

// A sample is the mean over 2 kAside + 1 parallel lines, 1 px apart. [-] [tuned:
// EachPlaceMeasuresTheMotionOfTheEdgeAcross]
constexpr int kAside = 2, kLines = 2 * kAside + 1;
constexpr int kStepSamples = 3;  // samples on either side that define a step
constexpr int kCentrings = 8;
// Positions in a window are fixed-point numbers with this many fractional bits, because
// floating-point conversions per sample took two thirds of the time of one camera's checks. [by
// definition]
constexpr int kPlaces = 20;
constexpr double kSlack = 1e-3;  // margin, larger than their rounding [px]

std::int32_t Whole(double px) {
  return static_cast<std::int32_t>(std::lround(std::ldexp(px, kPlaces)));
}
// Returns the fractional part of a fixed-point position.
float PartOf(std::int32_t whole) {
  constexpr std::int32_t kOne = 1 << kPlaces;  // [by definition]
  return static_cast<float>(whole & (kOne - 1)) / kOne;
}

}  // namespace

EdgeProfile::EdgeProfile(const GreyFormat& format, int max_half)
    : format_(format),
      level_(static_cast<std::size_t>(2 * max_half + 1)),
      places_(kLines * level_.size()) {
  const auto edge = static_cast<std::size_t>(2 * (max_half + kAside) + 3);
  window_.resize(edge * edge);
}

bool EdgeProfile::Read(const cv::Mat& image, const Eigen::Vector2d& p, const Eigen::Vector2d& n,
                       int half) noexcept {
  const Eigen::Vector2d t(-n.y(), n.x());
  const Eigen::Vector2d extent =
      half * n.cwiseAbs() + kAside * t.cwiseAbs() + Eigen::Vector2d::Constant(kSlack);
  const Eigen::Vector2d low = p - extent, high = p + extent;
  const bool inside = low.minCoeff() >= 0 && high.x() < image.cols - 1 && high.y() < image.rows - 1;
  if (!inside) return false;  // also false for NaN
  const cv::Rect box(cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
                     cv::Point(static_cast<int>(high.x()) + 2, static_cast<int>(high.y()) + 2));
  format_.Read(image, box, window_.data());
  half_ = half;
  const std::int32_t n_x = Whole(n.x()), n_y = Whole(n.y());
  const std::int32_t p_x = Whole(p.x() - box.x), p_y = Whole(p.y() - box.y);
  Place* place = places_.data();
  for (int k = -half; k <= half; ++k) {
    for (int j = -kAside; j <= kAside; ++j, ++place) {
      const std::int32_t x = p_x + k * n_x - j * n_y, y = p_y + k * n_y + j * n_x;
      *place = {(y >> kPlaces) * box.width + (x >> kPlaces), PartOf(x), PartOf(y)};
    }
  }
  place = places_.data();
  for (int k = 0; k <= 2 * half; ++k) {
    float sum = 0;
    for (int j = 0; j < kLines; ++j, ++place) {
      sum += Bilinear(window_.data() + place->at, box.width, place->right, place->down);
    }
    level_[static_cast<std::size_t>(k)] = sum / kLines;
  }
  return true;
}

// Returns the difference between the means of three samples after and before `k`, of which the
// nearest is `first` samples away.
double EdgeProfile::StepAt(int k, int first) const noexcept {
  const float* at = level_.data() + k + half_;
  float sum = 0;
  for (int j = first; j < first + kStepSamples; ++j) sum += at[j] - at[-j];
  return sum / kStepSamples;
}

// Returns the mean of three samples.
double EdgeProfile::Level(int k) const noexcept {
  const float* at = level_.data() + k + half_;
  return (at[-1] + at[0] + at[1]) / 3;
}

// Returns the centroid of the profile's slopes of this sign around the sample `at`. The window is
// moved until it is centred, and samples at its ends are weighted with their part inside.
double EdgeProfile::Centroid(double sign, int at, double half_window) const noexcept {
  double centre = at;
  for (int round = 0; round < kCentrings; ++round) {
    double sum = 0, moment = 0;
    const int first = std::max(-half_, static_cast<int>(std::floor(centre - half_window - 1)));
    const int end = std::min(half_, static_cast<int>(std::ceil(centre + half_window)) + 1);
    for (int k = first; k < end; ++k) {
      const double s = k + 0.5;
      const double inside = std::clamp(half_window - std::abs(s - centre) + 0.5, 0.0, 1.0);
      if (inside == 0) continue;
      const float* here = level_.data() + k + half_;
      const double slope = inside * sign * (here[1] - here[0]);
      sum += slope;
      moment += slope * (s - centre);
    }
    if (!(sum > 0)) return centre;
    const double move = std::clamp(moment / sum, -1.0, 1.0);
    centre += move;
    if (std::abs(move) < 1e-3) break;
  }
  return centre;
}

}  // namespace palpate
