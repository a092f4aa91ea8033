#include "slave/pipeline/points/surface_estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "slave/pipeline/estimate_rules.h"
#include "slave/pipeline/local_model/stiffness_scale.h"
#include "slave/pipeline/stopwatch.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::string_view kPulls =
    "the load pulls outward: check the sides (left, right), the rig and the object's pose";
constexpr double kVouchedFor = 0.5;    // of the larger side, where the model states no range
constexpr double kSpread = 0.1;        // of that ratio before anything was felt
constexpr double kLearningTime = 0.1;  // [s], of the ratio felt / modelled
constexpr double kNear = 0.1;  // of the larger side: a load farther from the tip is another's
constexpr double kBesideEdge =
    1e-3;  // of the larger side: a tip so far beside the surface is off it

double LargerSide(const SurfaceMesh& surface) {
  Vector3d lower = surface.nodes.front(), upper = lower;
  for (const Vector3d& p : surface.nodes) {
    lower = lower.cwiseMin(p);
    upper = upper.cwiseMax(p);
  }
  return (upper - lower).maxCoeff();
}

// A tool can only press; what pulls is seen the wrong way round.
void DoubtPull(SurfaceLoad* load) {
  if (!IsForceKnown(load->validity) || !(load->force > load->sigma_force)) return;
  load->validity = Worse(load->validity, Validity::kExtrapolated);
  load->why = kPulls;
}

}  // namespace

struct SurfaceEstimator::Parts {
  std::unique_ptr<LoadIdentifier> body;
  Isometry3d X_SO = Isometry3d::Identity(), X_OS = Isometry3d::Identity();
  double larger_side = 0;    // [m]
  double valid_radius = 0;   // of local models [m]
  double telling_depth = 0;  // [m]

  std::vector<SurfacePoint> points_O;
  SurfaceLoad load;
  ContactEstimate felt;
  StiffnessScale felt_ratio;
  double last_depth = std::numeric_limits<double>::quiet_NaN();  // of the tip, last picture [m]
  LocalModel local;                                              // the last one told
  SurfaceTimes times;
  EstimateRules rules;

  explicit Parts(const Scene& scene)
      : telling_depth(kTellingDepth * scene.operator_options.press_depth),
        felt_ratio(scene.operator_options.press_depth,
                   LearningRate(kLearningTime, SensorRate(scene.sense)), kSpread) {}
  void ToObject(const std::vector<SurfacePoint>& points_S);
  void Learn() noexcept;
  void Tell() noexcept;
  void Lose(Validity validity) noexcept;
};

SurfaceEstimator::SurfaceEstimator(const Scene& scene) : parts_(std::make_unique<Parts>(scene)) {
  parts_->X_SO = scene.object.X_SO;
  parts_->X_OS = scene.object.X_SO.inverse();
  Adopt(MakeLoadIdentifier(scene), scene);
}

SurfaceEstimator::~SurfaceEstimator() = default;

void SurfaceEstimator::Adopt(std::unique_ptr<LoadIdentifier> body, const Scene& scene) {
  parts_->body = std::move(body);
  parts_->rules.Adopt(scene);
  const double range = parts_->body->info().range;
  parts_->larger_side = LargerSide(parts_->body->surface());
  parts_->valid_radius = (range > 0 ? range : kVouchedFor) * parts_->larger_side;
  parts_->felt_ratio.Forget();
}

void SurfaceEstimator::Reset() noexcept {
  parts_->body->Reset();
  parts_->load = {};
  parts_->felt_ratio.Forget();
  parts_->rules.Reset();
}

const ContactEstimate& SurfaceEstimator::Feel(const SurfaceObservation& seen,
                                              const Vector3d& p_S_tip) noexcept {
  Parts& my = *parts_;
  ContactEstimate& felt = my.felt;
  felt.sample = seen.sequence;
  felt.sensed_at = seen.sensed_at;
  felt.events.Clear();
  if (p_S_tip.allFinite()) felt.p_S_tip = p_S_tip;
  my.rules.Track(seen.found, &felt);
  if (seen.found) {
    Stopwatch lap;
    my.ToObject(seen.points);
    my.load = my.body->Fit(my.points_O);
    DoubtPull(&my.load);
    my.times.mechanics.Add(lap.Lap());
    my.Tell();
    my.Learn();
  } else {
    my.Lose(Validity::kTrackingLost);
  }
  felt.local_model = LocalAt(felt.p_S_tip);
  return felt;
}

void SurfaceEstimator::Parts::ToObject(const std::vector<SurfacePoint>& points_S) {
  const Matrix3d R_OS = X_OS.linear();
  points_O = points_S;
  for (SurfacePoint& point : points_O) {
    point.p_S_rest = X_OS * point.p_S_rest;
    point.p_S = X_OS * point.p_S;
    point.covariance = R_OS * point.covariance * R_OS.transpose();
  }
}

// The load as the slave's words have it: the force of the object on the tool, frame S.
void SurfaceEstimator::Parts::Tell() noexcept {
  if (!IsForceKnown(load.validity)) return Lose(load.validity);
  const bool pressed = load.force != 0;
  rules.Touch(pressed, &felt);
  Vector3d p_O = load.p_O, n_O = load.n_O;
  if (!pressed) body->Nearest(X_OS * felt.p_S_tip, &p_O, &n_O);
  felt.p_S_contact = X_SO * p_O;
  felt.depth = std::max(0.0, load.depth);
  rules.TellForce(-load.force * (X_SO.linear() * n_O), load.sigma_force, load.validity, &felt);
}

void SurfaceEstimator::Parts::Lose(Validity validity) noexcept {
  EstimateRules::LoseForce(validity, &felt);
  last_depth = std::numeric_limits<double>::quiet_NaN();
}

// What the load that explains the points says of the press that the tip's depth alone would be. The
// tip's depth is of another moment than the picture: what it moved since the last one is an error.
void SurfaceEstimator::Parts::Learn() noexcept {
  const Vector3d p_O_tip = X_OS * felt.p_S_tip;
  Vector3d p_O, n_O;
  body->Nearest(p_O_tip, &p_O, &n_O);
  const double depth = n_O.dot(p_O - p_O_tip);
  const double moved = std::abs(depth - std::exchange(last_depth, depth));
  const bool is_the_tips = (load.p_O - p_O).norm() < kNear * larger_side;
  if (felt.validity != Validity::kValid || !is_the_tips || !(depth > telling_depth)) return;
  const LoadIdentifier::Press press = body->PressAt(p_O, depth);
  if (!press.valid) return;
  const double sigma = std::hypot(load.sigma_force, press.stiffness * moved);
  felt_ratio.Learn(depth, CompareForces(-load.force, sigma, press.force));
}

// f(p) = F_r n + k n n^T (reference - p) is right in force and slope at the present depth d with
// F_r = F - k d: below zero for a stiffening membrane, whose tangent meets zero below the surface.
LocalModel SurfaceEstimator::LocalAt(const Vector3d& p_S_tip) noexcept {
  Parts& my = *parts_;
  if (!p_S_tip.allFinite()) return my.local;
  const Vector3d p_O_tip = my.X_OS * p_S_tip;
  Vector3d p_O, n_O;
  my.body->Nearest(p_O_tip, &p_O, &n_O);
  double depth = n_O.dot(p_O - p_O_tip);
  const LoadIdentifier::Press modelled = my.body->PressAt(p_O, std::max(0.0, depth));
  auto press = my.felt_ratio.Scaled({modelled.force, modelled.stiffness}, std::max(0.0, depth));
  const bool usable =
      std::isfinite(press.force) && std::isfinite(press.stiffness) && press.stiffness > 0;
  if (!usable) return my.local;
  // The plane goes on where the surface has ended: beyond its edge nothing is touched.
  const double beside = (p_O_tip - p_O + depth * n_O).norm();
  if (beside > kBesideEdge * my.larger_side) depth = press.stiffness = 0;
  LocalModel next;
  next.normal = my.X_SO.linear() * n_O;
  next.reference = my.X_SO * p_O;
  if (depth > 0) next.force = (press.force - press.stiffness * depth) * next.normal;
  next.stiffness = press.stiffness * next.normal * next.normal.transpose();
  next.valid_radius = my.valid_radius;
  next.in_contact = depth > 0;
  my.local = Revised(next, my.local);
  return my.local;
}

const ContactEstimate& SurfaceEstimator::felt() const {
  return parts_->felt;
}
const SurfaceLoad& SurfaceEstimator::load() const {
  return parts_->load;
}
LoadIdentifier& SurfaceEstimator::body() {
  return *parts_->body;
}
const Isometry3d& SurfaceEstimator::X_SO() const {
  return parts_->X_SO;
}
const SurfaceTimes& SurfaceEstimator::times() const {
  return parts_->times;
}

void SurfaceEstimator::DeformedNodes(std::vector<Vector3d>* p_S) {
  parts_->body->Displacements(p_S);
  const std::vector<Vector3d>& rest = parts_->body->surface().nodes;
  for (std::size_t i = 0; i < rest.size(); ++i) {
    (*p_S)[i] = parts_->X_SO * Vector3d(rest[i] + (*p_S)[i]);
  }
}

void SurfaceEstimator::NodalForces(std::vector<Vector3d>* f_S) {
  parts_->body->NodalForces(f_S);
  for (Vector3d& force : *f_S) force = parts_->X_SO.linear() * force;
}

}  // namespace palpate
