#include "slave/vision/rest_edge.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace palpate {
namespace {

constexpr std::size_t kMaxPlaces = 256;  // [-] [tuned: EachPlaceMeasuresTheMotionOfTheEdgeAcross]
constexpr double kNeighbour = 14;  // points farther apart than this are on different pieces [px]
// Smallest cosine between the directions to the point and from it [-]. [tuned:
// EachPlaceMeasuresTheMotionOfTheEdgeAcross]
constexpr double kStraightRest = 0.95;
// Error of the centroid [px]. [tuned: EachPlaceMeasuresTheMotionOfTheEdgeAcross]
constexpr double kHalfRestWindow = 4;
constexpr double kMinRestStep = 3;   // [1/255 of full scale]
constexpr double kMinOfStep = 0.25;  // of the place's step at rest
constexpr double kFarther = 0.3;     // reduction of a step's weight at the end of the reach
constexpr int kWide = 6;             // from a blurred edge to its sides [px]
// Distance from the edge of the pixels that determine the levels of its sides [px].
constexpr int kBright = 5;
constexpr int kRaster = 2;         // of the search for a shift [px]
constexpr std::size_t kEvery = 3;  // every third position is searched

}  // namespace

Eigen::Matrix2d ImageMotion::linear() const {
  return std::exp(growth) * Eigen::Rotation2Dd(angle).toRotationMatrix();
}

RestEdge::RestEdge(const cv::Mat& first, const GreyFormat& format, CurveView rest)
    : profile_(format, kMaxReach + kMargin) {
  const std::size_t n = rest.size(), stride = (n + kMaxPlaces - 1) / kMaxPlaces;
  for (std::size_t i = 0; i < n; i += std::max<std::size_t>(stride, 1)) {
    const Eigen::Vector2d in = rest[i] - rest[(i + n - 1) % n], out = rest[(i + 1) % n] - rest[i];
    const bool one_piece = std::max(in.norm(), out.norm()) < kNeighbour &&
                           in.normalized().dot(out.normalized()) > kStraightRest;
    if (!one_piece) continue;
    const Eigen::Vector2d t = (in + out).normalized();
    Place place{rest[i], {t.y(), -t.x()}, 0};
    if (!profile_.Read(first, place.p_I, place.n_I, kMargin)) continue;
    place.step = profile_.StepAt(0);
    place.dark = std::min(profile_.Level(-kBright), profile_.Level(kBright));
    if (const auto edge = Locate(first, place, place.p_I, place.n_I, 3)) {
      place.p_I += *edge * place.n_I;
      places_.push_back(place);
    }
  }
  votes_.resize(places_.size() * (2 * kMaxReach + 1));
  normals_.resize(places_.size());
}

std::optional<double> RestEdge::Locate(const cv::Mat& image, const Place& place,
                                       const Eigen::Vector2d& p, const Eigen::Vector2d& n,
                                       int reach) noexcept {
  if (!profile_.Read(image, p, n, reach + kMargin)) return std::nullopt;
  const double sign = place.step > 0 ? 1 : -1;
  double best = 0, steepest = 0;
  int at = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double step = sign * profile_.StepAt(k);
    const double counts = step * (1 - kFarther * std::abs(k) / (reach + 1));
    if (counts > best) best = counts, steepest = step, at = k;
  }
  const double least = std::max(kMinRestStep * profile_.format().levels_per_255(),
                                kMinOfStep * std::abs(place.step));
  if (steepest < least) return std::nullopt;
  const double edge = profile_.Centroid(sign, at, kHalfRestWindow);
  if (std::abs(edge) > reach + 1) return std::nullopt;
  const int nearest = std::clamp(static_cast<int>(std::lround(edge)), -reach, reach);
  const double wide = sign * profile_.StepAt(nearest, kWide);
  sharpness_ = wide > 0 ? std::min(sign * profile_.StepAt(nearest) / wide, 1.0) : 1;
  Expose(place, nearest);
  return edge;
}

void RestEdge::Expose(const Place& place, int at) noexcept {
  const double behind = profile_.Level(at - kBright), ahead = profile_.Level(at + kBright);
  const double full = 255 * profile_.format().levels_per_255();
  const double grown = std::min(behind, ahead) / std::max(place.dark, 1.0);
  const bool clipped = std::max(behind, ahead) > full - 1.5 * profile_.format().levels_per_255();
  exposure_ = clipped ? grown * (place.dark + std::abs(place.step)) / full : 0;
}

double RestEdge::Votes(const Eigen::Vector2d& shift) const noexcept {
  constexpr int kRow = 2 * kMaxReach + 1;  // [by definition]
  float sum = 0;
  for (std::size_t i = 0; i < places_.size(); i += kEvery) {
    const auto along = static_cast<int>(std::lround(normals_[i].dot(shift)));
    if (std::abs(along) > kMaxReach) continue;
    sum += votes_[i * kRow + static_cast<std::size_t>(along + kMaxReach)];
  }
  return sum;
}

Eigen::Vector2d RestEdge::FindShift(const cv::Mat& image, const ImageMotion& motion) noexcept {
  constexpr int kRow = 2 * kMaxReach + 1;  // [by definition]
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(motion.angle).toRotationMatrix();
  for (std::size_t i = 0; i < places_.size(); i += kEvery) {
    float* row = votes_.data() + i * kRow;
    std::fill_n(row, kRow, 0.0F);
    normals_[i] = turn * places_[i].n_I;
    if (!profile_.Read(image, motion.Apply(places_[i].p_I), normals_[i],
                       kMaxReach + EdgeProfile::kMargin))
      continue;
    for (int k = -kMaxReach; k <= kMaxReach; ++k) {
      row[k + kMaxReach] =
          static_cast<float>(std::clamp(profile_.StepAt(k) / places_[i].step, 0.0, 1.0));
    }
  }
  const int reach = kMaxReach - 2;
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
