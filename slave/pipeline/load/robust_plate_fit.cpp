#include "slave/pipeline/load/robust_plate_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <new>

#include "slave/checks/points/noise_limits.h"
#include "slave/pipeline/load/plate_limits.h"
#include "slave/statistics/robust.h"

namespace palpate {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

bool IsUsable(const SurfacePoint& point) {
  const double variance = point.covariance(2, 2);
  return point.seen && (point.p_S - point.p_S_rest).allFinite() && variance > 0 &&
         std::isfinite(variance) &&
         std::isfinite(std::sqrt(point.covariance.topLeftCorner<2, 2>().trace()));
}

bool IsKnown(const LoadFit& load) {
  return load.validity != Validity::kFailed || load.nothing;
}

}  // namespace

RobustPlateFit::RobustPlateFit(PlateSurface& plate, const PlateSurface::Tool& tool,
                               PlateSurface* finer, TighterPlate tighter)
    : plate_(plate), tighter_(tighter), tool_(tool), fitter_(plate, tool, finer) {
  // Allocates memory for the solutions, because a fit must not allocate.
  const Contact none = PlateSurface::ToolContact(Contact::Kind::kForce, {0, 0}, tool, 0);
  plate.Solve({&none, 1}, &coarse_);
  if (tighter.plate != nullptr) tighter.plate->Solve({&none, 1}, &tight_);
}

// Keeps one row per point, so that nothing is allocated when points are hidden. If there are too
// many points, it uses visible ones at equal steps of their order.
void RobustPlateFit::Read(const std::vector<SurfacePoint>& points_O) {
  visible_.clear();
  visible_.reserve(points_O.size());
  std::size_t on_plate = 0;
  for (std::size_t i = 0; i < points_O.size(); ++i) {
    if (!(points_O[i].p_S_rest.head<2>().norm() <= plate_.radius())) continue;
    ++on_plate;
    if (IsUsable(points_O[i])) visible_.push_back(i);
  }
  const std::size_t size = std::min(on_plate, PlateLimits::kMaxPoints);
  const std::size_t used = std::min(size, visible_.size());
  rows_.assign(size, {});
  sorted_.reserve(size);
  places_.resize(size);
  displacements_.resize(size);
  sigmas_.resize(size);
  for (std::size_t k = 0; k < used; ++k) {
    const SurfacePoint& point = points_O[visible_[k * visible_.size() / used]];
    Row& row = rows_[k];
    row.place = point.p_S_rest.head<2>();
    row.moved = point.p_S - point.p_S_rest;
    row.sigma = std::sqrt(point.covariance(2, 2));
    row.sigma_along = std::sqrt(point.covariance.topLeftCorner<2, 2>().trace() / 2);
    row.usable = true;
  }
  usable_ = static_cast<int>(used);
}

PlateFit RobustPlateFit::Fit(const std::vector<SurfacePoint>& points_O) noexcept {
  PlateFit fit;
  try {
    Read(points_O);
  } catch (const std::bad_alloc&) {
    fit.load.reason = "out of memory";
    return fit;
  }
  const double slide = Slide();
  fit = FitRim(slide);
  LearnRim(fit, slide > 0);
  const Vector3d& motion = fit.load.rim_motion;
  fit.compensated = slide > 0 && slide < PlateLimits::kMaxSlide &&
                    std::abs(motion[0]) < PlateLimits::kMaxRise &&
                    motion.tail<2>().norm() < PlateLimits::kMaxTilt;
  fit.growth = Growth(fit.load);
  fit.deepest = deepest_;
  double square = 0;
  for (const Row& row : rows_) square += row.kept ? row.sigma * row.sigma : 0;
  fit.sigma = std::sqrt(square / std::max(1, kept_));
  if (fit.load.validity != Validity::kFailed && !fit.load.nothing) EstimateTension(&fit);
  return fit;
}

// Fits with the rim at its last position and, if that does not explain the points, with a free rim.
// A membrane that has slid has moved its rim.
PlateFit RobustPlateFit::FitRim(double slide) noexcept {
  const bool slid = slide > 0;
  const Vector3d offset = slid ? rim_motion_ : Vector3d::Zero();
  used_rim_ = !slid || rest_frames_ >= PlateLimits::kRestFrames;
  PlateFit fit;
  if (used_rim_) fit = FitLoad(Rim::kStays, offset);
  if (!used_rim_ || !Explains(fit) || (slid && !IsKnown(fit.load))) {
    const PlateFit free = FitLoad(Rim::kMayMove, Vector3d::Zero());
    const bool better = free.left_out < fit.left_out ||
                        free.load.residual < PlateLimits::kClearlyBetter * fit.load.residual;
    if (slid || (IsKnown(free.load) && better && RimMoved(free.load))) {
      used_rim_ = false;
      fit = free;
    } else {
      fit = FitLoad(Rim::kStays, offset);
    }
  }
  if (used_rim_) fit.load.rim_motion += offset;
  fit.moved = slid || !used_rim_;
  return fit;
}

bool RobustPlateFit::Explains(const PlateFit& fit) const noexcept {
  return fit.left_out <= PlateLimits::kManyLeftOut * fit.points &&
         fit.load.residual <= PlateLimits::kPoorFit && !RimMoved(fit.load);
}

void RobustPlateFit::LearnRim(const PlateFit& fit, bool slid) noexcept {
  if (!slid) rest_frames_ = 0;
  if (!slid || !fit.load.nothing) return;
  // The rim moved again.
  if (!used_rim_ && rest_frames_ >= PlateLimits::kRestFrames) rest_frames_ = 0;
  if (rest_frames_ == 0) rim_motion_.setZero();
  rest_frames_ = std::min(rest_frames_ + 1, PlateLimits::kMaxRestFrames);
  rim_motion_ += (fit.load.rim_motion - rim_motion_) / rest_frames_;
}

// Iteratively reweighted least squares: if there are outliers, rounds with Cauchy weights, so that
// outliers do not mask each other, and a last one without the remaining outliers.
PlateFit RobustPlateFit::FitLoad(Rim rim, const Vector3d& offset) noexcept {
  PlateFit fit;
  fit.points = kept_ = usable_;
  for (Row& row : rows_) {
    row.kept = row.usable;
    row.weight = row.usable ? 1 : 0;
    row.offset = offset[0] + offset.tail<2>().dot(row.place / plate_.radius());
  }
  fitter_.Allow(PlateLimits::kMaxPresses);
  fit.load = SolveWeighted(rim, true);
  bool outliers = FindOutliers(fit.load, rim);
  for (int round = 0; outliers && round <= PlateLimits::kSoftRounds; ++round) {
    const bool is_last = round == PlateLimits::kSoftRounds;
    SetWeights(is_last);
    fitter_.Reset();
    fit.load = SolveWeighted(rim, is_last);
    if (!is_last) FindOutliers(fit.load, rim);
  }
  fit.left_out = usable_ - kept_;
  return fit;
}

LoadFit RobustPlateFit::SolveWeighted(Rim rim, bool is_last) noexcept {
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Row& row = rows_[i];
    places_[i] = row.place;
    displacements_[i] = row.moved.z() - row.offset;
    sigmas_[i] = row.weight > 0 ? row.sigma / row.weight : std::numeric_limits<double>::infinity();
  }
  return is_last ? fitter_.Fit(places_, displacements_, sigmas_, rim)
                 : fitter_.FitCoarsely(places_, displacements_, sigmas_, rim);
}

void RobustPlateFit::SetWeights(bool is_last) noexcept {
  for (Row& row : rows_) {
    if (!row.usable) continue;
    const double by_scale = row.residual / (PlateLimits::kSoft * scatter_ * row.sigma);
    row.weight = is_last ? (row.kept ? 1 : 0) : 1 / std::sqrt(1 + by_scale * by_scale);
  }
}

// Computes residuals, their scatter, and which points are within the limit; true: there are
// outliers.
bool RobustPlateFit::FindOutliers(const LoadFit& load, Rim rim) noexcept {
  deepest_ = 0;
  sorted_.clear();
  for (Row& row : rows_) {
    if (!row.usable) continue;
    double fitted = load.nothing ? 0 : answered().Displacement(solution(), row.place);
    deepest_ = std::max(deepest_, std::abs(fitted));
    if (rim == Rim::kMayMove) {
      fitted += load.rim_motion[0] + load.rim_motion.tail<2>().dot(row.place / plate_.radius());
    }
    row.residual = row.moved.z() - row.offset - fitted;
    sorted_.push_back(std::abs(row.residual) / row.sigma);
  }
  if (usable_ <= PlateLimits::kMinPoints) return false;
  scatter_ = std::max(NoiseLimits::kMinScatter, SigmaOfSizes(sorted_));
  kept_ = 0;
  for (Row& row : rows_) {
    const double accepted = std::max(NoiseLimits::kSignificant * scatter_ * row.sigma,
                                     PlateLimits::kModelError * deepest_);
    row.kept = row.usable && std::abs(row.residual) <= accepted;
    kept_ += row.kept ? 1 : 0;
  }
  return kept_ < usable_;
}

// Returns the standard deviation of a common motion of all points, relative to that of one point
// [-].
double RobustPlateFit::SigmaOfMean(const LoadFit& load) const noexcept {
  const double scatter = std::clamp(load.residual, NoiseLimits::kMinScatter, PlateLimits::kPoorFit);
  return scatter * std::sqrt(3.0 / kept_);
}

bool RobustPlateFit::RimMoved(const LoadFit& load) const noexcept {
  if (kept_ < PlateLimits::kMinPoints) return false;
  double sum = 0;
  for (const Row& row : rows_) sum += row.kept ? row.sigma * row.sigma : 0;
  const Vector3d& motion = load.rim_motion;
  const NuisanceParameter rim{std::hypot(motion[0], motion[1] / 2, motion[2] / 2),
                              SigmaOfMean(load) * std::sqrt(sum / kept_),
                              PlateLimits::kRimShare * deepest_};
  return rim.IsSignificant(LoadLimits::kWaldSigmas);
}

// Returns the common displacement of all points along the plate [m]; 0: within noise and the effect
// of a load.
double RobustPlateFit::Slide() noexcept {
  if (usable_ < PlateLimits::kMinPoints) return 0;
  double deepest = 0, sigma = 0;
  for (const Row& row : rows_) {
    if (!row.usable) continue;
    deepest = std::max(deepest, std::abs(row.moved.z()));
    sigma = std::max(sigma, row.sigma_along);
  }
  Vector2d slide(0, 0);
  bool is_significant = false;
  for (const int axis : {0, 1}) {
    sorted_.clear();
    for (const Row& row : rows_) {
      if (row.usable) sorted_.push_back(row.moved[axis]);
    }
    slide[axis] = MedianOf(sorted_);
    const double scatter = std::clamp(SigmaAboutMedian(sorted_) / sigma, NoiseLimits::kMinScatter,
                                      PlateLimits::kPoorFit);
    const NuisanceParameter along{slide[axis], scatter * std::sqrt(3.0 / usable_) * sigma,
                                  PlateLimits::kSidewaysShare * deepest};
    is_significant |= along.IsSignificant(LoadLimits::kWaldSigmas);
  }
  return is_significant ? slide.norm() : 0;
}

// Fits displacements along the plate that are proportional to the distance from the centre.
NuisanceParameter RobustPlateFit::Growth(const LoadFit& load) const noexcept {
  if (kept_ < PlateLimits::kMinPoints) return {};
  Vector2d middle(0, 0), slide(0, 0);
  double sigma = 0;
  for (const Row& row : rows_) {
    if (!row.kept) continue;
    middle += row.place / kept_;
    slide += row.moved.head<2>() / kept_;
    sigma = std::max(sigma, row.sigma_along);
  }
  double along = 0, square = 0;
  for (const Row& row : rows_) {
    if (!row.kept) continue;
    const Vector2d arm = row.place - middle;
    along += arm.dot(row.moved.head<2>() - slide);
    square += arm.squaredNorm();
  }
  if (!(square > 0)) return {};
  return {along / std::sqrt(square * kept_), SigmaOfMean(load) * sigma,
          PlateLimits::kGrowthShare * deepest_};
}

// Compares the coarse plate with itself, so that a different number of modes is not mistaken for
// tension.
void RobustPlateFit::EstimateTension(PlateFit* fit) noexcept {
  if (tighter_.plate == nullptr) return;
  const LoadFit& load = fit->load;
  const Contact contact =
      PlateSurface::ToolContact(Contact::Kind::kForce, load.p_O, tool_, load.force);
  const auto solve = [&](PlateSurface& plate, Solution* solution) {
    plate.Solve({&contact, 1}, solution);
    return solution->responses().front().validity != Validity::kFailed;
  };
  const bool is_coarse = &answered() == &plate_;
  if (!is_coarse && !solve(plate_, &coarse_)) return;
  if (!solve(*tighter_.plate, &tight_)) return;
  const Solution& coarse = is_coarse ? solution() : coarse_;
  double information = 0;
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Vector2d& p = rows_[i].place;
    displacements_[i] =
        (tighter_.plate->Displacement(tight_, p) - plate_.Displacement(coarse, p)) / tighter_.more;
    if (rows_[i].kept) information += 1 / (rows_[i].sigma * rows_[i].sigma);
  }
  const LoadFitter::Sought tension = fitter_.Seek(displacements_);
  const double model = PlateLimits::kLawsShape * deepest_ * std::sqrt(information) * tension.sigma;
  fit->tension = {tension.amount, tension.sigma, model};
  fit->force_per_tension = tension.force;
}

}  // namespace palpate
