#include "slave/pipeline/load/robust_plate_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "shared/statistics/robust.h"
#include "slave/checks/points/noise_limits.h"
#include "slave/pipeline/load/plate_limits.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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
  if (chosen_.size() <= PlateLimits::kMostPoints) return chosen_;
  squares_.assign(static_cast<std::size_t>(PlateLimits::kSquares) * PlateLimits::kSquares, {});
  for (const int i : chosen_) Add(points_O[static_cast<std::size_t>(i)], i);
  chosen_.clear();
  for (const Square& square : squares_) {
    if (square.has_points) chosen_.push_back(square.nearest);
  }
  return chosen_;
}

void GridSubsample::Add(const SurfacePoint& point, int index) {
  const Eigen::Vector2d at = (point.p_S_rest.head<2>() / radius_ + Eigen::Vector2d::Ones()) *
                             (PlateLimits::kSquares / 2.0);
  const int column = std::min(static_cast<int>(at.x()), PlateLimits::kSquares - 1);
  const int row = std::min(static_cast<int>(at.y()), PlateLimits::kSquares - 1);
  Square& square = squares_[static_cast<std::size_t>(row) * PlateLimits::kSquares +
                            static_cast<std::size_t>(column)];
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
  answer.put_right = slide > 0 && slide < PlateLimits::kMostSlide &&
                     std::abs(rise[0]) < PlateLimits::kMostRise &&
                     rise.tail<2>().norm() < PlateLimits::kMostTilt;
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
  if (rest_frames_ < PlateLimits::kRestFrames) return false;
  RaiseAll(-rim_motion_);
  KeepAll();
  *answer = FitKept(Rim::kStays);
  const bool explains = IsKnown(answer->load) && answer->load.residual <= PlateLimits::kPoorFit &&
                        answer->left_out <= PlateLimits::kManyLeftOut * answer->points &&
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
  if (!held_ && rest_frames_ >= PlateLimits::kRestFrames) rest_frames_ = 0;  // it moved again
  if (rest_frames_ == 0) rim_motion_.setZero();
  rest_frames_ = std::min(rest_frames_ + 1, PlateLimits::kMostRestFrames);
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
  if (answer->left_out <= PlateLimits::kManyLeftOut * answer->points &&
      answer->load.residual <= PlateLimits::kPoorFit && !RimMoved(answer->load) && !(*slide > 0)) {
    return;
  }
  KeepAll();
  const Answer freed = FitKept(Rim::kMayMove);
  const bool better = freed.left_out < answer->left_out ||
                      freed.load.residual < PlateLimits::kClearlyBetter * answer->load.residual;
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
  fitter_.Allow(PlateLimits::kMostPresses);
  answer.load = FitWeighed(rim, Modes::kAsNeeded);
  if (Sift(answer.load, rim)) {
    for (int round = 0; round < PlateLimits::kSoftRounds; ++round) {
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
    const double off = point.residual / (PlateLimits::kSoft * scatter_ * point.sigma);
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
  if (usable_ <= PlateLimits::kLeastPoints) return false;
  scatter_ = std::max(NoiseLimits::kLeastScatter, SigmaOfSizes(sorted_));
  kept_ = 0;
  for (Seen& point : seen_) {
    const double accepted = std::max(NoiseLimits::kStandsOut * scatter_ * point.sigma,
                                     PlateLimits::kModelError * deepest_);
    point.kept = point.usable && std::abs(point.residual) <= accepted;
    kept_ += point.kept ? 1 : 0;
  }
  return kept_ < usable_;
}

// One standard deviation of a motion of all points together, by their sigma along z [-].
double RobustPlateFit::NoiseOfMotion(const LoadFit& load) const noexcept {
  const double scatter =
      std::clamp(load.residual, NoiseLimits::kLeastScatter, PlateLimits::kPoorFit);
  return scatter * std::sqrt(3.0 / kept_);
}

bool RobustPlateFit::RimMoved(const LoadFit& load) const noexcept {
  if (kept_ < PlateLimits::kLeastPoints) return false;
  double sum = 0;
  for (const Seen& point : seen_) sum += point.kept ? point.sigma * point.sigma : 0;
  const double sigma = std::sqrt(sum / kept_);
  const double motion =
      std::hypot(load.rim_motion[0], load.rim_motion[1] / 2, load.rim_motion[2] / 2);
  return motion > PlateLimits::kMotionSigmas * NoiseOfMotion(load) * sigma +
                      PlateLimits::kRimShare * deepest_;
}

// How far all points went along the plate together [m]; 0: no farther than noise and a press carry
// them.
double RobustPlateFit::Slide(const LoadFit& load) noexcept {
  if (kept_ < PlateLimits::kLeastPoints) return 0;
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
  const double accepted = PlateLimits::kMotionSigmas * NoiseOfMotion(load) * sigma +
                          PlateLimits::kSidewaysShare * deepest_;
  return slid.cwiseAbs().maxCoeff() > accepted ? slid.norm() : 0;
}

// By the displacements along the plate that go with the places' distance from their middle.
bool RobustPlateFit::HasGrown(const LoadFit& load) const noexcept {
  if (kept_ < PlateLimits::kLeastPoints) return false;
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
  return growth > PlateLimits::kMotionSigmas * NoiseOfMotion(load) * sigma +
                      PlateLimits::kGrowthShare * deepest_;
}

double RobustPlateFit::Off(int unknowns) const noexcept {
  double square = 0;
  for (const Seen& point : seen_) square += point.kept ? point.residual * point.residual : 0;
  return std::sqrt(square / std::max(1, kept_ - unknowns));
}

// Where neighbours all lie off to one side, each may be within the noise.
double RobustPlateFit::Cluster() const noexcept {
  const double reach = PlateLimits::kReach * plate_.radius();
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
    if (count < PlateLimits::kNeighbours || mean < NoiseLimits::kStandsOut * sigma ||
        mean < PlateLimits::kModelError * deepest_)
      continue;
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
  answer->sigma_of_law =
      PlateLimits::kLawsShape * deepest_ * std::sqrt(certainty) * answer->tension.sigma;
}

}  // namespace palpate
