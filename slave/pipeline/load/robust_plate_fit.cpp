#include "slave/pipeline/load/robust_plate_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "shared/statistics/robust.h"
#include "slave/pipeline/load/rest_shape.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kSquares = 11;  // across: the plate meets 109 of the 121

constexpr int kSoftRounds = 6;  // of fits with softened weights
// Of the plate for fits with the same rim: a rig that was bumped, put right, needs up to 650, a rim
// that moved 1000. Points that no load explains, of a mirrored picture say, took seconds.
constexpr long kMostPresses = 1300;
constexpr double kSoft = 2;             // standard deviations of the scatter at which they fall
constexpr double kOutlier = 5;          // standard deviations of the points' scatter
constexpr double kLeastScatter = 0.25;  // of the stated sigmas
constexpr double kModelError = 0.05;    // of the largest deflection: may be the model's own
constexpr double kManyLeftOut = 0.15;   // share: a moved rim may explain them better
constexpr double kPoorFit = 2;          // residual: likewise
constexpr double kClearlyBetter = 0.7;  // residual with a moved rim by that without
constexpr double kMotionSigmas = 6;     // at which a motion counts
constexpr double kRimShare = 0.02;      // of the depth: as much may be the model's error
constexpr double kSidewaysShare = 0.1;  // of the depth: a press carries its points so far
constexpr double kGrowthShare = 0.03;   // of the depth: a press draws its points together so far
constexpr int kLeastPoints = 5;
constexpr int kRestFrames = 5, kMostRestFrames = 100;  // that tell the rim's motion, remembered
constexpr double kLawsShape = 0.9e-3;  // of the depth: error of the plate's shape around a load
constexpr double kReach = 0.3;         // of a cluster of neighbours [radii]
constexpr int kNeighbours = 3;

bool IsKnown(const LoadFit& load) {
  return load.validity != Validity::kFailed || load.nothing;
}

}  // namespace

const std::vector<int>& GridSubsample::Of(const std::vector<SurfacePoint>& points_O) {
  chosen_.clear();
  chosen_.reserve(points_O.size());
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    if (points_O[i].p_S_rest.head<2>().norm() <= radius_) chosen_.push_back(static_cast<int>(i));
  }
  if (chosen_.size() <= kMost) return chosen_;
  squares_.assign(static_cast<std::size_t>(kSquares) * kSquares, {});
  for (const int i : chosen_) Add(points_O[static_cast<std::size_t>(i)], i);
  chosen_.clear();
  for (const Square& square : squares_) {
    if (square.has_points) chosen_.push_back(square.nearest);
  }
  return chosen_;
}

void GridSubsample::Add(const SurfacePoint& point, int index) {
  const Eigen::Vector2d at =
      (point.p_S_rest.head<2>() / radius_ + Eigen::Vector2d::Ones()) * (kSquares / 2.0);
  const int column = std::min(static_cast<int>(at.x()), kSquares - 1);
  const int row = std::min(static_cast<int>(at.y()), kSquares - 1);
  Square& square =
      squares_[static_cast<std::size_t>(row) * kSquares + static_cast<std::size_t>(column)];
  square.has_points = true;
  if (!point.seen) return;
  const double distance = (at - Eigen::Vector2d(column + 0.5, row + 0.5)).squaredNorm();
  if (square.nearest != kNone && distance >= square.distance) return;
  square.nearest = index;
  square.distance = distance;
}

// One entry per point or square, so that nothing is allocated when some hide.
void RobustPlateFit::Read(const std::vector<SurfacePoint>& points_O) {
  const std::vector<int>& chosen = choice_.Of(points_O);
  seen_.assign(chosen.size(), {});
  sorted_.reserve(chosen.size());
  places_.resize(chosen.size());
  displacements_.resize(chosen.size());
  sigmas_.resize(chosen.size());
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] == GridSubsample::kNone) continue;
    const SurfacePoint& point = points_O[static_cast<std::size_t>(chosen[i])];
    Seen& seen = seen_[i];
    const Vector2d place = point.p_S_rest.head<2>();
    const Vector3d moved = point.p_S - point.p_S_rest;
    const double sigma = std::sqrt(point.covariance(2, 2));
    const double sideways = std::sqrt(point.covariance.topLeftCorner<2, 2>().trace() / 2);
    const bool usable = point.seen && moved.allFinite() && sigma > 0 && std::isfinite(sigma) &&
                        std::isfinite(sideways);
    if (usable) seen = {place, moved, sigma, sideways, 0, 1, true, true};
  }
  usable_ = static_cast<int>(std::ranges::count_if(seen_, &Seen::usable));
}

RobustPlateFit::Answer RobustPlateFit::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  try {
    Read(points_O);
  } catch (const std::bad_alloc&) {
    Answer none;
    none.load.reason = "out of memory";
    return none;
  }
  Answer answer;
  double slide = 0;
  held_ = false;
  if (!slid_ || !FitSlid(&answer, &slide)) Refit(&answer, &slide);
  slid_ = slide > 0;
  LearnRim(answer);
  answer.moved = answer.moved || slide > 0;
  const Eigen::Vector3d& rise = answer.load.rim_motion;
  answer.put_right = slide > 0 && slide < kMostSlide && std::abs(rise[0]) < kMostRise &&
                     rise.tail<2>().norm() < kMostTilt;
  answer.flat = IsFlat(RestShapeOf(points_O, plate_.radius()), plate_.thickness());
  answer.grown = HasGrown(answer.load);
  answer.off = Off(answer.load.nothing ? 0 : 3);
  answer.deepest = deepest_;
  if (answer.load.validity == Validity::kFailed || answer.load.nothing) return answer;
  answer.cluster = Cluster();
  SeekTension(&answer);
  return answer;
}

// What has slid once mostly stays so. False: nothing that was fitted says so.
bool RobustPlateFit::FitSlid(Answer* answer, double* slide) noexcept {
  held_ = FitHeld(answer);
  if (!held_) {
    KeepAll();
    *answer = FitKept(Rim::kMayMove);
  }
  *slide = Slide(answer->load);
  answer->moved = true;
  return *slide > 0 && IsKnown(answer->load);
}

// With the rim where it was when nothing pressed. False: that is not known, or it moved again.
bool RobustPlateFit::FitHeld(Answer* answer) noexcept {
  if (rest_frames_ < kRestFrames) return false;
  RaiseAll(-rim_motion_);
  KeepAll();
  *answer = FitKept(Rim::kStays);
  const bool explains = IsKnown(answer->load) && answer->load.residual <= kPoorFit &&
                        answer->left_out <= kManyLeftOut * answer->points &&
                        !RimMoved(answer->load);
  if (explains) {
    answer->load.rim_motion += rim_motion_;
  } else {
    RaiseAll(rim_motion_);
  }
  return explains;
}

void RobustPlateFit::LearnRim(const Answer& answer) noexcept {
  if (!slid_) rest_frames_ = 0;
  if (!slid_ || !answer.load.nothing) return;
  if (!held_ && rest_frames_ >= kRestFrames) rest_frames_ = 0;  // it moved again
  if (rest_frames_ == 0) rim_motion_.setZero();
  rest_frames_ = std::min(rest_frames_ + 1, kMostRestFrames);
  rim_motion_ += (answer.load.rim_motion - rim_motion_) / rest_frames_;
}

void RobustPlateFit::RaiseAll(const Vector3d& rim_motion) noexcept {
  for (Seen& point : seen_) {
    const Vector2d x = point.place / plate_.radius();
    point.moved.z() += rim_motion[0] + rim_motion.tail<2>().dot(x);
  }
}

void RobustPlateFit::Refit(Answer* answer, double* slide) noexcept {
  KeepAll();
  *answer = FitKept(Rim::kStays);
  *slide = Slide(answer->load);
  if (answer->left_out <= kManyLeftOut * answer->points && answer->load.residual <= kPoorFit &&
      !RimMoved(answer->load) && !(*slide > 0)) {
    return;
  }
  KeepAll();
  const Answer freed = FitKept(Rim::kMayMove);
  const bool better = freed.left_out < answer->left_out ||
                      freed.load.residual < kClearlyBetter * answer->load.residual;
  if (IsKnown(freed.load) && (*slide > 0 || (better && RimMoved(freed.load)))) {
    *answer = freed;
    answer->moved = true;
    *slide = Slide(answer->load);
  } else if (IsKnown(answer->load)) {
    KeepAll();
    *answer = FitKept(Rim::kStays);
  }
}

void RobustPlateFit::KeepAll() noexcept {
  for (Seen& point : seen_) {
    point.kept = point.usable;
    point.weight = point.usable ? 1 : 0;
  }
  kept_ = usable_;
}

// Where points stand out of the fit's residuals, least squares are bent by them and may hide one
// behind another: so first fits in which a point weighs the less the farther it lies off (Cauchy's
// weights), and then one without those that lie off that.
RobustPlateFit::Answer RobustPlateFit::FitKept(Rim rim) noexcept {
  Answer answer;
  answer.points = usable_;
  fitter_.Allow(kMostPresses);
  answer.load = FitWeighed(rim, Modes::kAsNeeded);
  if (Sift(answer.load, rim)) {
    for (int round = 0; round < kSoftRounds; ++round) {
      Soften();
      fitter_.Reset();
      answer.load = FitWeighed(rim, Modes::kFew);
      Sift(answer.load, rim);
    }
    for (Seen& point : seen_) point.weight = point.kept ? 1 : 0;
    fitter_.Reset();
    answer.load = FitWeighed(rim, Modes::kAsNeeded);
  }
  answer.left_out = usable_ - kept_;
  return answer;
}

LoadFit RobustPlateFit::FitWeighed(Rim rim, Modes modes) noexcept {
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    places_[i] = seen_[i].place;
    displacements_[i] = seen_[i].moved.z();
    sigmas_[i] = seen_[i].weight > 0 ? seen_[i].sigma / seen_[i].weight
                                     : std::numeric_limits<double>::infinity();
  }
  return modes == Modes::kFew ? fitter_.FitCoarsely(places_, displacements_, sigmas_, rim)
                              : fitter_.Fit(places_, displacements_, sigmas_, rim);
}

void RobustPlateFit::Soften() noexcept {
  for (Seen& point : seen_) {
    if (!point.usable) continue;
    const double off = point.residual / (kSoft * scatter_ * point.sigma);
    point.weight = 1 / std::sqrt(1 + off * off);
  }
}

// Which points lie within what is accepted; true: not all.
bool RobustPlateFit::Sift(const LoadFit& load, Rim rim) noexcept {
  deepest_ = 0;
  sorted_.clear();
  for (Seen& point : seen_) {
    if (!point.usable) continue;
    double fitted = load.nothing ? 0 : answered().Displacement(solution(), point.place);
    deepest_ = std::max(deepest_, std::abs(fitted));
    if (rim == Rim::kMayMove) {
      const Vector2d x = point.place / plate_.radius();
      fitted += load.rim_motion[0] + load.rim_motion.tail<2>().dot(x);
    }
    point.residual = point.moved.z() - fitted;
    sorted_.push_back(std::abs(point.residual) / point.sigma);
  }
  if (usable_ <= kLeastPoints) return false;
  scatter_ = std::max(kLeastScatter, SigmaOfSizes(sorted_));
  kept_ = 0;
  for (Seen& point : seen_) {
    const double accepted = std::max(kOutlier * scatter_ * point.sigma, kModelError * deepest_);
    point.kept = point.usable && std::abs(point.residual) <= accepted;
    kept_ += point.kept ? 1 : 0;
  }
  return kept_ < usable_;
}

// One standard deviation of a motion of all points together, by their sigma along z [-].
double RobustPlateFit::NoiseOfMotion(const LoadFit& load) const noexcept {
  const double scatter = std::clamp(load.residual, kLeastScatter, kPoorFit);
  return scatter * std::sqrt(3.0 / kept_);
}

bool RobustPlateFit::RimMoved(const LoadFit& load) const noexcept {
  if (kept_ < kLeastPoints) return false;
  double sum = 0;
  for (const Seen& point : seen_) sum += point.kept ? point.sigma * point.sigma : 0;
  const double sigma = std::sqrt(sum / kept_);
  const double motion =
      std::hypot(load.rim_motion[0], load.rim_motion[1] / 2, load.rim_motion[2] / 2);
  return motion > kMotionSigmas * NoiseOfMotion(load) * sigma + kRimShare * deepest_;
}

// How far all points went along the plate together [m]; 0: no farther than noise and a press carry
// them.
double RobustPlateFit::Slide(const LoadFit& load) noexcept {
  if (kept_ < kLeastPoints) return 0;
  Eigen::Vector2d slid(0, 0);
  double sigma = 0;
  for (const int axis : {0, 1}) {
    sorted_.clear();
    sigma = 0;
    for (const Seen& point : seen_) {
      if (!point.kept) continue;
      sorted_.push_back(point.moved[axis]);
      sigma = std::max(sigma, point.sideways);
    }
    slid[axis] = MedianOf(sorted_);
  }
  const double accepted = kMotionSigmas * NoiseOfMotion(load) * sigma + kSidewaysShare * deepest_;
  return slid.cwiseAbs().maxCoeff() > accepted ? slid.norm() : 0;
}

// By the displacements along the plate that go with the places' distance from their middle.
bool RobustPlateFit::HasGrown(const LoadFit& load) const noexcept {
  if (kept_ < kLeastPoints) return false;
  Vector2d middle(0, 0), slid(0, 0);
  double sigma = 0;
  for (const Seen& point : seen_) {
    if (!point.kept) continue;
    middle += point.place / kept_;
    slid += point.moved.head<2>() / kept_;
    sigma = std::max(sigma, point.sideways);
  }
  double along = 0, square = 0;
  for (const Seen& point : seen_) {
    if (!point.kept) continue;
    const Vector2d arm = point.place - middle;
    along += arm.dot(point.moved.head<2>() - slid);
    square += arm.squaredNorm();
  }
  if (!(square > 0)) return false;
  const double growth = std::abs(along) / std::sqrt(square * kept_);
  return growth > kMotionSigmas * NoiseOfMotion(load) * sigma + kGrowthShare * deepest_;
}

double RobustPlateFit::Off(int unknowns) const noexcept {
  double square = 0;
  for (const Seen& point : seen_) square += point.kept ? point.residual * point.residual : 0;
  return std::sqrt(square / std::max(1, kept_ - unknowns));
}

// Where neighbours all lie off to one side, each may be within the noise.
double RobustPlateFit::Cluster() const noexcept {
  const double reach = kReach * plate_.radius();
  double largest = 0;
  for (const Seen& middle : seen_) {
    if (!middle.kept) continue;
    double sum = 0, weights = 0;
    int count = 0;
    for (const Seen& point : seen_) {
      if (!point.kept || (point.place - middle.place).squaredNorm() > reach * reach) continue;
      const double weight = 1 / (point.sigma * point.sigma);
      sum += weight * point.residual;
      weights += weight;
      ++count;
    }
    const double mean = std::abs(sum) / weights;
    const double sigma = std::max(1.0, scatter_) / std::sqrt(weights);
    if (count < kNeighbours || mean < kOutlier * sigma || mean < kModelError * deepest_) continue;
    largest = std::max(largest, mean);
  }
  return deepest_ > 0 ? largest / deepest_ : 0;
}

// The coarse plate against itself, so that no difference of modes is taken for tension.
void RobustPlateFit::SeekTension(Answer* answer) noexcept {
  if (tighter_.plate == nullptr) return;
  const LoadFit& load = answer->load;
  const Contact press =
      PlateSurface::DiscContact(Contact::Kind::kForce, load.p_O, width_, load.force);
  const auto solve = [&](PlateSurface& plate, Solution* solution) {
    plate.Solve({&press, 1}, solution);
    return solution->responses().front().validity != Validity::kFailed;
  };
  const bool is_coarse = &answered() == &plate_;
  if (!is_coarse && !solve(plate_, &coarse_)) return;
  if (!solve(*tighter_.plate, &tight_)) return;
  const Solution& coarse = is_coarse ? solution() : coarse_;
  double certainty = 0;
  for (std::size_t i = 0; i < seen_.size(); ++i) {
    const Vector2d& p = seen_[i].place;
    displacements_[i] =
        (tighter_.plate->Displacement(tight_, p) - plate_.Displacement(coarse, p)) / tighter_.more;
    if (seen_[i].kept) certainty += 1 / (seen_[i].sigma * seen_[i].sigma);
  }
  answer->tension = fitter_.Seek(displacements_);
  answer->sigma_of_law = kLawsShape * deepest_ * std::sqrt(certainty) * answer->tension.sigma;
}

}  // namespace palpate
