#include "slave/vision/dots/stereo_dots.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include "shared/text/text.h"
#include "slave/mesh/index.h"
#include "slave/statistics/robust.h"
#include "slave/vision/stereo/rig.h"

namespace palpate {
namespace {

// Tolerance of the distances between neighbours relative to the layout: a membrane stretches
// little, but an array that is matched to its shifted copy has another depth and size.
constexpr double kSizeTolerance = 0.12;

bool Fits(const cv::Mat& image, const Lens& lens) {
  return image.dims == 2 && image.type() == CV_8UC1 && image.data != nullptr &&
         image.cols == lens.size[0] && image.rows == lens.size[1];
}

StereoDots::Params Checked(StereoDots::Params params) {
  for (const Lens* lens : {&params.rig.left, &params.rig.right}) {
    if (!(lens->fx > 0 && lens->fy > 0 && lens->size[0] > 0 && lens->size[1] > 0)) {
      throw std::invalid_argument("rig: expected lenses with focal lengths > 0 and a size > 0");
    }
  }
  if (!(params.rig.baseline() > 0)) {
    throw std::invalid_argument("rig: baseline = 0: expected > 0");
  }
  Require(params.dot_radius >= 0 && params.dot_radius < 1, "dot_radius", params.dot_radius,
          "0 <= radius < 1 m");
  Require(params.sigma_px >= 0 && params.sigma_px < 100, "sigma_px", params.sigma_px,
          "0 <= sigma < 100 px");
  Require(params.rest_images >= 1, "rest_images", 1.0 * params.rest_images, "at least 1");
  Require(params.miss_px > 0, "miss_px", params.miss_px, "> 0");
  return params;
}

// Returns the image positions of the array's dots at rest in the left and the right camera [px].
std::array<std::vector<Eigen::Vector2d>, 2> Projected(const StereoDots::Params& params) {
  const Eigen::Isometry3d X_LO = params.X_SL.inverse() * params.X_SO;
  std::array<std::vector<Eigen::Vector2d>, 2> places;
  for (const Eigen::Vector2d& p_O : params.layout) {
    const Eigen::Vector3d p_L = X_LO * Eigen::Vector3d(p_O.x(), p_O.y(), 0);
    const auto left = Project(params.rig.left, p_L);
    const auto right = Project(params.rig.right, params.rig.X_RL * p_L);
    if (!left || !right) {
      throw std::invalid_argument("pose: expected the array of dots in front of both cameras");
    }
    places[0].push_back(*left);
    places[1].push_back(*right);
  }
  return places;
}

std::array<DotTracker, 2> MakeTrackers(const StereoDots::Params& params) {
  auto [left, right] = Projected(params);
  DotTracker::Params tracker;
  tracker.finder = params.finder;
  return {DotTracker(params.layout, std::move(left), tracker),
          DotTracker(params.layout, std::move(right), tracker)};
}

}  // namespace

StereoDots::StereoDots(const Params& params)
    : params_(Checked(params)), trackers_(MakeTrackers(params)) {
  const std::size_t n = params_.layout.size();
  observation_.points.resize(n);
  for (std::size_t k = 0; k < n; ++k) observation_.points[k].id = static_cast<int>(k);
  rest_counts_.assign(n, 0);
  rest_sums_.assign(n, Eigen::Vector3d::Zero());
  raw_.resize(n);
  located_.resize(n);
  ratios_.reserve(8 * n);
}

const SurfaceObservation& StereoDots::Observe(const cv::Mat& left, const cv::Mat& right) noexcept {
  observation_.found = false;
  for (SurfacePoint& point : observation_.points) point.seen = false;
  if (!Fits(left, params_.rig.left) || !Fits(right, params_.rig.right)) return observation_;
  const bool in_left = trackers_[0].Process(left), in_right = trackers_[1].Process(right);
  if (!in_left || !in_right) return observation_;
  if (!Locate()) {
    for (DotTracker& tracker : trackers_) tracker.Lose();
    return observation_;
  }
  const bool was_known = at_rest_known();
  int seen = 0;
  for (std::size_t k = 0; k < located_.size(); ++k) {
    if (!located_[k] || (was_known && rest_counts_[k] == 0)) continue;
    SurfacePoint& point = observation_.points[k];
    const Eigen::Matrix3d R_SL = params_.X_SL.linear();
    point.p_S = params_.X_SL * located_[k]->p_L;
    point.covariance = R_SL * located_[k]->covariance * R_SL.transpose();
    const Dot &left_dot = trackers_[0].dots()[k].dot, &right_dot = trackers_[1].dots()[k].dot;
    point.left_I = left_dot.centre;
    point.right_I = right_dot.centre;
    point.sigma_px = std::hypot(left_dot.sigma, right_dot.sigma) / std::numbers::sqrt2;
    point.miss_px = located_[k]->miss_px;
    point.seen = true;
    ++seen;
  }
  if (!was_known) TakeRest();
  observation_.found = was_known && seen >= 3;
  if (was_known) CompareRest();
  return observation_;
}

// Computes the positions twice: the first ones determine the tilts of the dots, which the second
// ones include. False: the dots are not the array.
bool StereoDots::Locate() {
  const Eigen::Vector3d flat = Eigen::Vector3d::Zero();
  int both = 0, met = 0;
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    raw_[k].reset();
    if (!trackers_[0].dots()[k].seen || !trackers_[1].dots()[k].seen) continue;
    ++both;
    raw_[k] = Place(k, flat);
    if (raw_[k] && std::abs(raw_[k]->miss_px) > params_.miss_px) raw_[k].reset();
    if (raw_[k]) ++met;
  }
  if (met < 3 || 2 * met < both || !SizeFits()) return false;
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    located_[k] = raw_[k] ? Place(k, Normal(k)) : std::nullopt;
  }
  return true;
}

// `n_L`: normal of the dot; zero: its tilt is unknown and not corrected.
std::optional<Triangulated> StereoDots::Place(std::size_t k,
                                              const Eigen::Vector3d& n_L) const noexcept {
  const Dot& left = trackers_[0].dots()[k].dot;
  const Dot& right = trackers_[1].dots()[k].dot;
  Eigen::Vector2d left_I = left.centre, right_I = right.centre;
  if (raw_[k] && n_L.squaredNorm() > 0) {
    const Eigen::Vector3d p_L = raw_[k]->p_L;
    const Eigen::Isometry3d& X_RL = params_.rig.X_RL;
    const auto bias_left = CircleCentroidBias(params_.rig.left, p_L, n_L, params_.dot_radius);
    const auto bias_right =
        CircleCentroidBias(params_.rig.right, X_RL * p_L, X_RL.linear() * n_L, params_.dot_radius);
    if (bias_left && bias_right) {
      left_I -= *bias_left;
      right_I -= *bias_right;
    }
  }
  const double sigma = std::max({params_.sigma_px, left.sigma, right.sigma});
  return Triangulate(params_.rig, left_I, right_I, sigma);
}

// Returns the normal of the plane through the neighbours, by least squares of positions over the
// layout's x and y.
Eigen::Vector3d StereoDots::Normal(std::size_t k) const noexcept {
  Eigen::Matrix2d D = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, 3, 2> P = Eigen::Matrix<double, 3, 2>::Zero();
  for (const int j : trackers_[0].array().neighbours(k)) {
    const auto other = Index(j);
    if (!raw_[other]) continue;
    const Eigen::Vector2d d = params_.layout[other] - params_.layout[k];
    D += d * d.transpose();
    P += (raw_[other]->p_L - raw_[k]->p_L) * d.transpose();
  }
  const double determinant = D(0, 0) * D(1, 1) - D(0, 1) * D(1, 0);
  if (!(determinant > 1e-3 * D.trace() * D.trace())) return Eigen::Vector3d::Zero();
  Eigen::Matrix2d inverse;
  inverse << D(1, 1), -D(0, 1), -D(1, 0), D(0, 0);
  const Eigen::Matrix<double, 3, 2> tangents = P * inverse / determinant;
  const Eigen::Vector3d normal = tangents.col(0).cross(tangents.col(1));
  const double length = normal.norm();
  return length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d(Eigen::Vector3d::Zero());
}

bool StereoDots::SizeFits() noexcept {
  ratios_.clear();
  for (std::size_t k = 0; k < raw_.size(); ++k) {
    for (const int j : trackers_[0].array().neighbours(k)) {
      const auto other = Index(j);
      if (other < k || !raw_[k] || !raw_[other]) continue;
      ratios_.push_back((raw_[k]->p_L - raw_[other]->p_L).norm() /
                        (params_.layout[k] - params_.layout[other]).norm());
    }
  }
  if (ratios_.empty()) return true;
  size_ = MedianOf(ratios_);
  return std::abs(size_ - 1) < kSizeTolerance;
}

void StereoDots::TakeRest() noexcept {
  ++rest_taken_;
  rest_sizes_ += size_;
  for (std::size_t k = 0; k < rest_sums_.size(); ++k) {
    SurfacePoint& point = observation_.points[k];
    if (point.seen) {
      rest_sums_[k] += point.p_S;
      ++rest_counts_[k];
    }
    if (rest_counts_[k] > 0) point.p_S_rest = rest_sums_[k] / rest_counts_[k];
    if (!point.seen) point.p_S = point.p_S_rest;
  }
}

// Compares the baseline with the layout.
void StereoDots::CompareRest() noexcept {
  const Eigen::Isometry3d X_OS = params_.X_SO.inverse();
  Eigen::Vector2d aside(0, 0);
  double apart = 0;
  for (std::size_t k = 0; k < rest_counts_.size(); ++k) {
    const auto& neighbours = trackers_[0].array().neighbours(k);
    if (rest_counts_[k] == 0 || neighbours.empty()) continue;
    aside += (X_OS * observation_.points[k].p_S_rest).head<2>() - params_.layout[k];
    apart += (params_.layout[Index(neighbours.front())] - params_.layout[k]).norm();
  }
  observation_.scale_error = std::abs(rest_sizes_ / rest_taken_ - 1);
  observation_.place_error = apart > 0 ? aside.norm() / apart : 0;
}

}  // namespace palpate
