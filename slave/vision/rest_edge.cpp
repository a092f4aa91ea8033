#include "slave/vision/rest_edge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace palpate {
namespace {

constexpr std::size_t kMostPlaces = 256;  // [-] [tuned: EachPlaceTellsHowFarTheEdgeHasMovedAcross]
constexpr double kNeighbour = 14;  // farther apart than this, points lie on different pieces [px]
// Cosine between the ways to the point and from it. [-] [tuned:
// EachPlaceTellsHowFarTheEdgeHasMovedAcross]
constexpr double kStraight = 0.95;
// A profile is the mean of 2 kAside + 1 lines, 1 px apart. [-] [tuned:
// EachPlaceTellsHowFarTheEdgeHasMovedAcross]
constexpr int kAside = 2;
constexpr int kStep = 3;  // samples on either side that tell a step
// Of the centroid [px]. [tuned: EachPlaceTellsHowFarTheEdgeHasMovedAcross]
constexpr double kHalfWindow = 4;
constexpr int kCentrings = 8;
constexpr double kLeastStep = 3;       // [1/255 of full scale]
constexpr double kLeastOfStep = 0.25;  // of the place's step at rest
constexpr double kFarther = 0.3;       // less a step counts at the end of the reach
constexpr int kBright = 5;             // from the edge to where its sides' levels are read [px]
constexpr int kRaster = 2;             // of the search for a shift [px]
constexpr std::size_t kEvery = 3;      // place takes part in it
// Places in a window as whole numbers of 2^-20 px: taking floating point apart, sample by sample,
// was two thirds of what the checks of one camera cost. [by definition]
constexpr int kPlaces = 20;
constexpr double kSlack = 1e-3;  // more than their rounding [px]

std::int32_t Whole(double px) {
  return static_cast<std::int32_t>(std::lround(std::ldexp(px, kPlaces)));
}
// Of a place, the part behind the point.
float PartOf(std::int32_t whole) {
  constexpr std::int32_t kOne = 1 << kPlaces;  // [by definition]
  return static_cast<float>(whole & (kOne - 1)) / kOne;
}

}  // namespace

Eigen::Matrix2d PictureMotion::linear() const {
  return std::exp(growth) * Eigen::Rotation2Dd(angle).toRotationMatrix();
}

RestEdge::RestEdge(const cv::Mat& first, const GreyFormat& format, CurveView rest)
    : format_(format),
      window_(static_cast<std::size_t>((kMostSamples + 6) * (kMostSamples + 6))),
      level_(kMostSamples) {
  const std::size_t n = rest.size(), stride = (n + kMostPlaces - 1) / kMostPlaces;
  for (std::size_t i = 0; i < n; i += std::max<std::size_t>(stride, 1)) {
    const Eigen::Vector2d in = rest[i] - rest[(i + n - 1) % n], out = rest[(i + 1) % n] - rest[i];
    const bool one_piece = std::max(in.norm(), out.norm()) < kNeighbour &&
                           in.normalized().dot(out.normalized()) > kStraight;
    if (!one_piece) continue;
    const Eigen::Vector2d t = (in + out).normalized();
    Place place{rest[i], {t.y(), -t.x()}, 0};
    if (!ReadProfile(first, place.p_I, place.n_I, kMargin)) continue;
    place.step = StepAt(0);
    place.dark = std::min(Level(-kBright), Level(kBright));
    if (const auto edge = Locate(first, place, place.p_I, place.n_I, 3)) {
      place.p_I += *edge * place.n_I;
      places_.push_back(place);
    }
  }
  votes_.resize(places_.size() * (2 * kMostReach + 1));
  normals_.resize(places_.size());
}

bool RestEdge::ReadProfile(const cv::Mat& image, const Eigen::Vector2d& p, const Eigen::Vector2d& n,
                           int half) noexcept {
  const Eigen::Vector2d t(-n.y(), n.x());
  const Eigen::Vector2d extent =
      half * n.cwiseAbs() + kAside * t.cwiseAbs() + Eigen::Vector2d::Constant(kSlack);
  const Eigen::Vector2d low = p - extent, high = p + extent;
  const bool inside = low.minCoeff() >= 0 && high.x() < image.cols - 1 && high.y() < image.rows - 1;
  if (!inside) return false;  // so it is for NaN
  const cv::Rect box(cv::Point(static_cast<int>(low.x()), static_cast<int>(low.y())),
                     cv::Point(static_cast<int>(high.x()) + 2, static_cast<int>(high.y()) + 2));
  format_.Read(image, box, window_.data());
  half_ = half;
  const std::int32_t n_x = Whole(n.x()), n_y = Whole(n.y());
  const std::int32_t p_x = Whole(p.x() - box.x), p_y = Whole(p.y() - box.y);
  for (int k = -half; k <= half; ++k) {
    float sum = 0;
    for (int j = -kAside; j <= kAside; ++j) {
      const std::int32_t x = p_x + k * n_x - j * n_y, y = p_y + k * n_y + j * n_x;
      const float u = PartOf(x), v = PartOf(y);
      const std::int16_t* upper = window_.data() + (y >> kPlaces) * box.width + (x >> kPlaces);
      const std::int16_t* lower = upper + box.width;
      sum +=
          (1 - v) * ((1 - u) * upper[0] + u * upper[1]) + v * ((1 - u) * lower[0] + u * lower[1]);
    }
    level_[static_cast<std::size_t>(k + half)] = sum / (2 * kAside + 1);
  }
  return true;
}

// From the samples behind `k` to those ahead, `first` the nearest of three on either side.
double RestEdge::StepAt(int k, int first) const noexcept {
  const float* at = level_.data() + k + half_;
  float sum = 0;
  for (int j = first; j < first + kStep; ++j) sum += at[j] - at[-j];
  return sum / kStep;
}

// Mean of three samples.
double RestEdge::Level(int k) const noexcept {
  const float* at = level_.data() + k + half_;
  return (at[-1] + at[0] + at[1]) / 3;
}

// Of the profile's slopes of this sign around the sample `at`; the window is moved until it is
// centred, and its ends count by the part of a sample that lies inside.
double RestEdge::Centroid(double sign, int at) const noexcept {
  double centre = at;
  for (int round = 0; round < kCentrings; ++round) {
    double sum = 0, moment = 0;
    for (int k = -half_; k < half_; ++k) {
      const double s = k + 0.5;
      const double inside = std::clamp(kHalfWindow - std::abs(s - centre) + 0.5, 0.0, 1.0);
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

std::optional<double> RestEdge::Locate(const cv::Mat& image, const Place& place,
                                       const Eigen::Vector2d& p, const Eigen::Vector2d& n,
                                       int reach) noexcept {
  if (!ReadProfile(image, p, n, reach + kMargin)) return std::nullopt;
  const double sign = place.step > 0 ? 1 : -1;
  double best = 0, steepest = 0;
  int at = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double step = sign * StepAt(k);
    const double counts = step * (1 - kFarther * std::abs(k) / (reach + 1));
    if (counts > best) best = counts, steepest = step, at = k;
  }
  const double least =
      std::max(kLeastStep * format_.levels_per_255(), kLeastOfStep * std::abs(place.step));
  if (steepest < least) return std::nullopt;
  const double edge = Centroid(sign, at);
  if (std::abs(edge) > reach + 1) return std::nullopt;
  const int nearest = std::clamp(static_cast<int>(std::lround(edge)), -reach, reach);
  const double wide = sign * StepAt(nearest, kMargin - kStep + 1);
  sharpness_ = wide > 0 ? std::min(sign * StepAt(nearest) / wide, 1.0) : 1;
  Expose(place, nearest);
  return edge;
}

void RestEdge::Expose(const Place& place, int at) noexcept {
  const double behind = Level(at - kBright), ahead = Level(at + kBright);
  const double full = 255 * format_.levels_per_255();
  const double grown = std::min(behind, ahead) / std::max(place.dark, 1.0);
  const bool clipped = std::max(behind, ahead) > full - 1.5 * format_.levels_per_255();
  exposure_ = clipped ? grown * (place.dark + std::abs(place.step)) / full : 0;
}

double RestEdge::Votes(const Eigen::Vector2d& shift) const noexcept {
  constexpr int kRow = 2 * kMostReach + 1;  // [by definition]
  float sum = 0;
  for (std::size_t i = 0; i < places_.size(); i += kEvery) {
    const auto along = static_cast<int>(std::lround(normals_[i].dot(shift)));
    if (std::abs(along) > kMostReach) continue;
    sum += votes_[i * kRow + static_cast<std::size_t>(along + kMostReach)];
  }
  return sum;
}

Eigen::Vector2d RestEdge::FindShift(const cv::Mat& image, const PictureMotion& motion) noexcept {
  constexpr int kRow = 2 * kMostReach + 1;  // [by definition]
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(motion.angle).toRotationMatrix();
  for (std::size_t i = 0; i < places_.size(); i += kEvery) {
    float* row = votes_.data() + i * kRow;
    std::fill_n(row, kRow, 0.0F);
    normals_[i] = turn * places_[i].n_I;
    if (!ReadProfile(image, motion.Apply(places_[i].p_I), normals_[i], kMostReach + kStep))
      continue;
    for (int k = -kMostReach; k <= kMostReach; ++k) {
      row[k + kMostReach] = static_cast<float>(std::clamp(StepAt(k) / places_[i].step, 0.0, 1.0));
    }
  }
  const int reach = kMostReach - 2;
  Eigen::Vector2d best(0, 0);
  double most = Votes(best);
  const auto offer = [&](const Eigen::Vector2d& shift) {
    const double votes = Votes(shift);
    if (votes > most) most = votes, best = shift;
  };
  for (int x = -reach; x <= reach; x += kRaster) {
    for (int y = -reach; y <= reach; y += kRaster) offer({x, y});
  }
  const Eigen::Vector2d rough = best;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) offer(rough + Eigen::Vector2d(x, y));
  }
  return best;
}

}  // namespace palpate
