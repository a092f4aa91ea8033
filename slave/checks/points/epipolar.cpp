#include "slave/checks/points/epipolar.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Cholesky>

#include "slave/checks/points/noise_limits.h"
#include "slave/statistics/robust.h"

namespace palpate {
namespace {

// Smallest number of points that determine a motion [-]. [derived: two for each unknown]
constexpr int kMinMotionPoints = 8;
// Weight of earlier pairs after each pair in the estimate of the lag [-]. [tuned: epipolar_test,
// images of different instants]
constexpr double kRemembered = 0.97;
// The same after a pair without information: clocks drift slowly [-]. [tuned: epipolar_test, what
// is at rest after a motion]
constexpr double kMemory = 0.999;
// Range of the scatter at rest, relative to the reported noise of the images, that this noise
// explains [-]. [tuned: epipolar_test, a scatter of 0.1 to 1.5 of the noise]
constexpr double kNoLess = 0.2, kNoMore = 1.1;
// Squared change of a position between two images relative to the squared miss, if both are noise
// [-]. [derived: the mean of two images in each of two pairs, against their difference]
constexpr double kNoiseMoves = 0.5;
// Smallest motion, relative to the apparent motion by noise, that gives information about the times
// of the images [-]. [tuned: skew_test]
constexpr double kMinMotion = 3;

constexpr std::string_view kMoved =
    "the distance between left and right rays is larger than at rest: one camera has moved";
constexpr std::string_view kOtherRig =
    "the left and right rays do not meet at rest: check the sides (left, right) and the rig";
constexpr std::string_view kWrongStamps =
    "the left and the right image were taken at other times than their timestamps";
constexpr std::string_view kLate =
    "the left and the right image were taken at different times, or one camera is frozen";

// Sums over points in one image: squared motion, motion times miss, squared miss, all divided by
// sigma, and the number of points.
struct Share {
  double motion = 0, product = 0, misses = 0, count = 0;
  void Add(const Share& other, double sign) noexcept {
    motion += sign * other.motion;
    product += sign * other.product;
    misses += sign * other.misses;
    count += sign * other.count;
  }
};

double Square(double x) {
  return x * x;
}

}  // namespace

// Motion that noise explains has no weight. Old information decays with each new pair, and slowly
// while nothing moves, because clocks drift.
void EpipolarCheck::Stamps::Learn(double motion, double product) noexcept {
  const double left = motion > 0 ? kRemembered : kMemory;
  for (double* sum : {&weight, &late, &square, &pairs}) *sum *= left;
  weights *= Square(left);
  if (!(motion > 0)) return;
  weight += motion;
  late += product;
  square += product * product / motion;
  weights += motion * motion;
  pairs += 1;
}

bool EpipolarCheck::Stamps::AreWrong() const noexcept {
  return std::abs(late) > NoiseLimits::kSignificant * std::sqrt(weight) &&
         std::abs(late) > PointsLimits::kMaxLag * weight;
}

// Before any motion it is the largest lag that is not flagged. Afterwards it combines the estimated
// lag, its uncertainty, and the variation between pairs beyond noise (R. DerSimonian, N. Laird,
// Controlled Clinical Trials 7, 1986).
double EpipolarCheck::Stamps::Sigma() const noexcept {
  const double unknown = PointsLimits::kMaxLag * PointsLimits::kMaxLag;
  if (!(weight > 0)) return PointsLimits::kMaxLag;
  const double known = unknown / (unknown + 1 / weight);
  const double mean = late / weight;
  const double apart = square - late * mean - (pairs - 1);
  const double freedom = weight - weights / weight;
  const double jitter = freedom > 1e-3 * weight ? std::max(0.0, apart / freedom) : 0;
  return std::sqrt(Square(known * mean) + known / weight + jitter);
}

void EpipolarCheck::Examine(const PointsSample& sample, Findings* findings) noexcept {
  SurfaceObservation* const seen = &sample.seen;
  if (rows_.size() != seen->points.size()) {
    rows_.assign(seen->points.size(), {});
    sorted_.reserve(rows_.size());
    evidence_.fill({});
    stamps_ = {};
    taken_ = 0;
    scatter_at_rest_ = std::numeric_limits<double>::infinity();
    noise_at_rest_ = 1;
  }
  newest_ = (newest_ + 1) % (kLags + 1);
  const double since = SecondsBetween(std::exchange(newest_at_, seen->sensed_at), seen->sensed_at);
  // Sign: a later image shows a newer position.
  reported_late_ = since > 0 ? -seen->skew / since : 0;
  bool any = false;
  for (const SurfacePoint& point : seen->points) any |= point.seen;
  const bool is_baseline = any && taken_ < rest_images_;
  for (std::size_t i = 0; i < rows_.size(); ++i) Read(seen->points[i], is_baseline, &rows_[i]);
  if (is_baseline && ++taken_ == rest_images_) {
    double square = 0, degrees = 0;
    for (const Row& row : rows_) {
      if (row.rest_count < 2) continue;
      square += row.rest_square - row.rest_miss * row.rest_miss / row.rest_count;
      degrees += row.rest_count - 1;
    }
    if (degrees >= kMinMotionPoints) {
      scatter_at_rest_ = std::sqrt(square / degrees);
      noise_at_rest_ = std::max(1.0, scatter_at_rest_);
    }
  }
  const bool as_stated = kNoLess < scatter_at_rest_ && scatter_at_rest_ < kNoMore;
  for (SurfacePoint& point : seen->points) point.errs_by_noise_alone = as_stated;
  if (taken_ < rest_images_) return;
  CheckRest(*seen, findings);
  if (ExplainByMotion()) CheckPair(seen, findings);
  // The mean time of the two images has half of the error of one of them.
  seen->moment_sigma = stamps_.Sigma() / 2;
}

// Misses at rest are accumulated relative to the noise that the image tracking reports.
void EpipolarCheck::Read(const SurfacePoint& point, bool is_baseline, Row* row) noexcept {
  const auto now = static_cast<std::size_t>(newest_);
  row->seen[now] = row->counts = row->kept = false;
  if (!point.seen || !(point.sigma_px > 0)) return;
  const double reported = std::numbers::sqrt2 * point.sigma_px;
  const Eigen::Vector2d across = AcrossEpipolar(rig_, point.left_I);
  // The position halfway between the two rays. Its noise is independent of that of the miss.
  row->places[now] = across.dot(point.left_I) - point.miss_px / 2;
  row->seen[now] = true;
  if (is_baseline) {
    ++row->rest_count;
    row->rest_miss += point.miss_px / reported;
    row->rest_square += point.miss_px * point.miss_px / (reported * reported);
    row->rest_place += (row->places[now] - row->rest_place) / row->rest_count;
  }
  if (row->rest_count == 0) return;
  row->sigma = reported * noise_at_rest_;
  row->miss = point.miss_px - reported * row->rest_miss / row->rest_count;
  const Lens& lens = rig_.left;
  const Eigen::Vector2d p((point.left_I.x() - lens.cx) * 2 / lens.size[0],
                          (point.left_I.y() - lens.cy) * 2 / lens.size[1]);
  row->motions = Eigen::Vector4d(1, p.x(), p.y(), p.x() * p.y()) / row->sigma;
  row->counts = row->kept = true;
}

// Fits twice. Points that deviate from the first fit are left out of the second one.
bool EpipolarCheck::ExplainByMotion() noexcept {
  for (int round = 0; round < 2; ++round) {
    normal_.setIdentity();
    normal_ *= 1e-6;
    Eigen::Vector4d slope(0, 0, 0, 0);
    count_ = 0;
    for (const Row& row : rows_) {
      if (!row.kept) continue;
      normal_ += row.motions * row.motions.transpose();
      slope += row.motions * (row.miss / row.sigma);
      ++count_;
    }
    if (count_ < kMinMotionPoints) return false;
    motion_ = normal_.ldlt().solve(slope);
    if (round == 0) DropOutliers();
  }
  return true;
}

void EpipolarCheck::DropOutliers() noexcept {
  sorted_.clear();
  for (const Row& row : rows_) {
    if (row.counts) sorted_.push_back(std::abs(Residual(row)));
  }
  scatter_ = std::max(1.0, SigmaOfSizes(sorted_));
  for (Row& row : rows_) {
    row.kept = row.counts && std::abs(Residual(row)) <= NoiseLimits::kSignificant * scatter_;
  }
}

// Returns the position of a point across its epipolar line `lag` images ago; beyond kLags at rest.
// NaN: not seen.
double EpipolarCheck::PositionAcross(const Row& row, int lag) const noexcept {
  if (lag > kLags) return row.rest_place;
  const auto then = static_cast<std::size_t>((newest_ + kLags + 1 - lag) % (kLags + 1));
  return row.seen[then] ? row.places[then] : std::nan("");
}

// Fits over all points, because a single wrong point differs from the others, and over consecutive
// pairs, because a lag is constant.
bool EpipolarCheck::IsOfAnotherInstant(int lag) noexcept {
  const auto moved = [&](const Row& row) {
    const double by_sigma = (PositionAcross(row, 0) - PositionAcross(row, lag)) / row.sigma;
    return row.counts && std::isfinite(by_sigma) ? by_sigma : 0.0;
  };
  // Leaves out the motion that a moved camera would explain.
  Eigen::Vector4d share(0, 0, 0, 0);
  for (const Row& row : rows_) {
    if (row.kept) share += row.motions * moved(row);
  }
  share = normal_.ldlt().solve(share);
  // Leaves out the point with the largest product: a point that one camera located wrongly has a
  // motion and a miss at the same time.
  Share most, sum;
  for (const Row& row : rows_) {
    if (!row.counts) continue;
    const double own = moved(row) - row.motions.dot(share), miss = Residual(row);
    const Share one{own * own, own * miss, miss * miss, 1};
    sum.Add(one, 1);
    if (std::abs(one.product) > std::abs(most.product)) most = one;
  }
  sum.Add(most, -1);
  const auto& [motion, product, misses, count] = sum;
  if (!(motion > 0)) return false;
  const double explained = product * product / motion;
  const double scatter = std::max(1.0, (misses - explained) / std::max(1.0, count - kMotions - 1));
  if (lag == 1) {
    const double noise = kNoiseMoves * std::max(0.0, count - kMotions);
    const double weight = motion > kMinMotion * noise ? (motion - noise) / scatter : 0;
    stamps_.Learn(weight, product / scatter - reported_late_ * weight);
  }
  Evidence& evidence = evidence_[static_cast<std::size_t>(lag - 1)];
  evidence.motion = kRemembered * evidence.motion + motion / scatter;
  evidence.product = kRemembered * evidence.product + product / scatter;
  return std::abs(evidence.product) > NoiseLimits::kSignificant * std::sqrt(evidence.motion) &&
         std::abs(evidence.product) > PointsLimits::kMaxLag * evidence.motion;
}

// Tests the part of the misses at rest that varies smoothly across the image, as with a wrong rig.
void EpipolarCheck::CheckRest(const SurfaceObservation& seen, Findings* findings) const noexcept {
  Matrix4 normal = 1e-6 * Matrix4::Identity();
  Eigen::Vector4d slope(0, 0, 0, 0);
  double square = 0;
  int count = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (row.rest_count == 0 || !row.counts) continue;
    const double rest = seen.points[i].miss_px - row.miss;
    const Eigen::Vector4d even = row.sigma * row.motions;
    normal += even * even.transpose();
    slope += rest * even;
    square += rest * rest;
    ++count;
  }
  if (count < kMinMotionPoints) return;
  const double explained = slope.dot(normal.ldlt().solve(slope));
  const double scatter = (square - explained) / (count - kMotions);
  const double most = max_at_rest_ + 2 * rig_.rms_px;
  if (explained > most * most * count + kMotions * NoiseLimits::kSignificant * scatter) {
    findings->Fail(FailedCheck::kEpipolar, kOtherRig);
  }
}

void EpipolarCheck::CheckPair(SurfaceObservation* seen, Findings* findings) noexcept {
  double square = 0, variance = 0, reported = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    if (!row.kept) continue;
    const double moved = row.sigma * row.motions.dot(motion_);
    square += moved * moved;
    variance += row.sigma * row.sigma;
    reported += seen->points[i].sigma_px * seen->points[i].sigma_px;
  }
  // Rms over the points: the part explained by a camera motion, and the scatter of a position per
  // axis [px].
  const double offset = std::sqrt(square / count_);
  const double noise = scatter_ * std::sqrt(variance / count_ / 2);
  const double known = noise * std::sqrt(2.0 * kMotions / count_);
  seen->epipolar_px = std::hypot(offset, noise);
  if (offset > PointsLimits::kMaxOffset + NoiseLimits::kSignificant * known) {
    findings->Fail(FailedCheck::kEpipolar, kMoved);
  }
  for (int lag = 1; lag <= kLags + 1; ++lag) {
    if (IsOfAnotherInstant(lag)) findings->Fail(FailedCheck::kInstants, kLate);
  }
  if (stamps_.AreWrong()) findings->Fail(FailedCheck::kInstants, kWrongStamps);
  // The scatter of the misses is also that of the positions. The reported noise understates it if
  // images are compressed or out of focus.
  const double known_px = std::max(sigma_px_, std::sqrt(reported / count_));
  if (noise <= known_px) return;
  const double wider = noise / known_px;
  for (SurfacePoint& point : seen->points) point.covariance *= wider * wider;
}

}  // namespace palpate
