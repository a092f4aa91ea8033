#include "slave/pipeline/fingertips/finger_local_model.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

#include "shared/mesh/disc_patch.h"
#include "slave/mesh/index.h"
#include "slave/pipeline/base/estimate_builder.h"
#include "slave/pipeline/local_model/patch_maker.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kVouchedFor = 0.5;  // range relative to the larger side if the model states none
constexpr double kMinShare = 0.25;   // of the full depth: contact does not begin without stiffness
constexpr double kOnSurface = 1e-6;  // of the radius
// Relative error of the model: with small strain and coarse meshes tens of percent for foams.
constexpr double kFingerSpread = 0.3;
// Time constant with which the stiffness follows the measured force [s]. [tuned:
// TheRenderedForceBecomesTheOneEstimated]
constexpr double kFingerLearningTime = 0.05;
// Time constant of the force's inclination at full depth; at smaller depths the weight is smaller
// [s]. [tuned: TheRenderedForceLeansAsTheOneEstimated]
constexpr double kLeanTime = 0.2;
// Largest inclination; beyond it no spring has this stiffness [-]. [by definition]
constexpr double kMaxLean = 0.5;
// Change relative to the force, a third of the perception threshold [-]. [derived: Weber fraction
// of 0.1]
constexpr double kTurned = 0.03;
// Smallest force whose direction is significant [sigmas]. [by definition]
constexpr double kSignificant = 3;

}  // namespace

FingerLocalModel::FingerLocalModel(const Scene& scene)
    : material_(scene.object.material),
      law_(scene.model.contact),
      radius_(scene.sense.Find<Tactile>()->finger_radius),
      disc_radius_(scene.sense.Find<Tactile>()->patch > 0
                       ? scene.sense.Find<Tactile>()->patch / 2
                       : DiscOfSphere(radius_, scene.operator_options.press_depth)),
      full_depth_(scene.operator_options.press_depth),
      scale_(full_depth_, LearningRate(kFingerLearningTime, scene.sense.Find<Tactile>()->rate),
             kFingerSpread),
      lean_rate_(LearningRate(kLeanTime, scene.sense.Find<Tactile>()->rate)) {}

void FingerLocalModel::Update(TactileBody& body, const Isometry3d& X_SO, const Isometry3d& X_SF,
                              bool in_contact, const std::optional<MeasuredForce>& measured,
                              LocalModel* model) noexcept {
  FindPlane(body, X_SO.inverse() * X_SF.translation());
  if (place_.triangle >= 0) Render(body, X_SO, X_SF, in_contact, measured, model);
}

void FingerLocalModel::Follow(TactileBody& body, const Isometry3d& X_SO, const Isometry3d& X_SF,
                              bool in_contact, LocalModel* model) noexcept {
  FindPlane(body, X_SO.inverse() * X_SF.translation());
  const bool is_known = place_.triangle >= 0 && body.stiffness->Knows(place_.triangle);
  if (is_known) Render(body, X_SO, X_SF, in_contact, std::nullopt, model);
}

void FingerLocalModel::Render(TactileBody& body, const Isometry3d& X_SO, const Isometry3d& X_SF,
                              bool in_contact, const std::optional<MeasuredForce>& measured,
                              LocalModel* model) noexcept {
  const Matrix3d& R = X_SO.linear();
  LocalModel next;
  next.normal = R * place_.n_O;
  // The vector from the deepest point of the sphere to the apex of the pad.
  const Vector3d to_apex = radius_ * (next.normal - X_SF.linear().col(2));
  next.reference = X_SO * place_.p_O + to_apex;
  const Matrix3d K_S =
      R * StiffnessOf(body, place_.triangle, place_.weights, depth_) * R.transpose();
  Size(K_S, measured, &next);
  if (measured && law_ != ContactLaw::kFrictionless) {
    const Vector3d p_S_apex = X_SF * Vector3d(0, 0, -radius_);
    LearnLean(*measured, next.force + next.stiffness * (next.reference - p_S_apex), R, next.normal);
  }
  const double range = body.deformation->info().range;
  next.valid_radius = (range > 0 ? range : kVouchedFor) * body.larger_side;
  next.in_contact = in_contact;
  *model = Revised(next, *model);
}

void FingerLocalModel::FindPlane(const TactileBody& body, const Vector3d& p_O_centre) noexcept {
  const auto nearest = body.contact->Find(p_O_centre, std::numeric_limits<double>::infinity());
  if (!nearest) return;
  const bool touches = nearest->inside || nearest->distance < radius_;
  const bool stays = touches && (law_ == ContactLaw::kBonded || nearest->inside);
  if (!stays || place_.triangle < 0) {
    place_ = *nearest;
    // Beside an edge or a corner the contact normal points from the edge to the sphere's centre.
    const Vector3d away = p_O_centre - place_.p_O;
    if (!place_.inside && away.norm() > kOnSurface * radius_) place_.n_O = away.normalized();
  }
  depth_ = radius_ - place_.n_O.dot(p_O_centre - place_.p_O);
}

// `K_S`: of the model at this depth.
void FingerLocalModel::Size(const Matrix3d& K_S, const std::optional<MeasuredForce>& measured,
                            LocalModel* model) noexcept {
  const Vector3d& n = model->normal;
  const double depth = std::max(0.0, depth_), stiffness = n.dot(K_S * n);
  modelled_ = depth * stiffness;
  if (measured) Learn(*measured, n, modelled_);
  const StiffnessScale::Press press = scale_.Scaled({depth * stiffness, stiffness}, depth);
  const double ratio = scale_.At(depth).ratio;
  model->stiffness = ratio * K_S + (press.stiffness - ratio * stiffness) * n * n.transpose();
  model->force = (press.force - press.stiffness * depth) * n;
}

// `modelled`: the normal force of the model at this depth [N].
void FingerLocalModel::Learn(const MeasuredForce& measured, const Vector3d& n_S,
                             double modelled) noexcept {
  const RatioSample sample = CompareForces(measured.force_S.dot(n_S), measured.sigma, modelled);
  if (!sample.is_informative || !(depth_ > kInformativeDepth * full_depth_)) return;
  scale_.Learn(depth_, sample);
}

void FingerLocalModel::LearnLean(const MeasuredForce& measured, const Vector3d& f_S,
                                 const Matrix3d& R_SO, const Vector3d& n_S) noexcept {
  const double along = n_S.dot(measured.force_S);
  if (!(along > kSignificant * measured.sigma) || !(depth_ > kInformativeDepth * full_depth_))
    return;
  const Vector3d missing = (measured.force_S - f_S) / along;
  const double share = std::min(1.0, depth_ / full_depth_);
  lean_O_ += share * lean_rate_ * (R_SO.transpose() * (missing - n_S.dot(missing) * n_S));
  lean_O_ *= std::min(1.0, kMaxLean / std::max(lean_O_.norm(), kMaxLean));
}

Matrix3d FingerLocalModel::StiffnessOf(TactileBody& body, int triangle, const Vector3d& weights,
                                       double depth) noexcept {
  const double share = std::clamp(depth / full_depth_, kMinShare, 1.0);
  const double radius = disc_radius_ * std::sqrt(share);
  const Vector3d& n = triangle == place_.triangle ? place_.n_O : Normal(body.surface, triangle);
  Matrix3d K;
  try {
    K = body.stiffness->At(triangle, weights, radius);
  } catch (const std::exception&) {  // out of memory for nodes that are computed on demand
    K = DiscStiffness(material_, radius, n);
  }
  const double along = n.dot(K * n);
  if (law_ == ContactLaw::kFrictionless) return along * n * n.transpose();
  // A spring is symmetric.
  const Vector3d lean = along * (lean_O_ - n.dot(lean_O_) * n);
  return K + lean * n.transpose() + n * lean.transpose();
}

bool FingerLocalModel::MakePatch(TactileBody& body, const Isometry3d& X_SO, const Isometry3d& X_SF,
                                 SurfacePatch* patch) noexcept {
  const Matrix3d& R = X_SO.linear();
  const auto stiffness = [&](const Vector3d& p_O, int triangle, const Vector3d&) -> Matrix3d {
    if (!body.stiffness->Knows(triangle)) return Matrix3d::Zero();
    Vector3d weights(0, 0, 0);
    for (std::size_t k = 0; k < 3; ++k) {
      const int node = body.surface.triangles[Index(triangle)][k];
      weights[static_cast<int>(k)] = body.surface.nodes[Index(node)] == p_O ? 1 : 0;
    }
    return R * StiffnessOf(body, triangle, weights, full_depth_) * R.transpose();
  };
  const Vector3d p_O = X_SO.inverse() * X_SF.translation();
  const bool frictionless = law_ == ContactLaw::kFrictionless;
  if (!FillPatch(body.surface, p_O, X_SO, frictionless, stiffness, patch)) return false;
  sent_lean_O_ = lean_O_;
  patch->tools[0] = {radius_ * X_SF.linear().col(2), radius_};
  patch->full_depth = full_depth_;
  const double range = body.deformation->info().range;
  patch->valid_depth = (range > 0 ? range : kVouchedFor) * body.larger_side;
  return true;
}

bool FingerLocalModel::HasOutgrownPatch() const noexcept {
  return (lean_O_ - sent_lean_O_).norm() > kTurned;
}

void FingerLocalModel::LearnLaw(TactileBody& body, PatchLaw* law) noexcept {
  if (place_.triangle < 0 || !body.stiffness->Knows(place_.triangle)) return;
  const auto along = [&](double depth) {
    const Matrix3d K = StiffnessOf(body, place_.triangle, place_.weights, depth);
    return place_.n_O.dot(K * place_.n_O);
  };
  const double full = along(full_depth_);
  for (int i = 0; i < kLawPoints; ++i) {
    const double depth = full_depth_ * i / (kLawPoints - 1);
    law->ratios[static_cast<std::size_t>(i)] = scale_.At(depth).ratio * along(depth) / full;
  }
}

}  // namespace palpate
