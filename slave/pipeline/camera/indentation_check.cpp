#include "slave/pipeline/camera/indentation_check.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

#include "slave/pipeline/camera/camera_limits.h"

namespace palpate {
namespace {

using Limits = CameraLimits;

constexpr std::string_view kOtherDent = "observed and computed indentation differ";
constexpr std::string_view kOtherEdge =
    "the object's edge lies beside the computed outline: something covers it, or touches elsewhere";
constexpr double kNear = 15;  // from the surface, where a dent is looked for [px]
// Sigma of a dent computed: [px], relative, besides relative as elements are long for the tool.
constexpr double kFloor = 0.2, kModel = 0.05, kMesh = 0.1;
constexpr double kSigmas = 3.5;
constexpr double kFirst = 1;      // at which a round tool's is taken before it touches [px]
constexpr double kDeepens = 0.1;  // part of its depth after which it is taken anew
constexpr int kDistrust = 3;      // pictures that must agree before a dent is believed again
constexpr int kMostApart = 7;     // places in a row: a dent, or a cover, where none is to be
constexpr double kRough = 0.12;   // part of the dent that the tip's sigma may be
constexpr int kUnconfirmed = 6;   // pictures in which a dent may stay out of sight
constexpr double kCovered = 0.3;  // of the tip's template, unless its dent is seen

}  // namespace

// Displacements along the normal and, where the contact sticks, across it.
bool IndentationCheck::Take(const BoundaryPlace& place, double depth, TouchModel* touch) noexcept {
  const Eigen::Vector3d n = Planar(place.normal_O), t(-n.y(), n.x(), 0);
  const double unit = touch->indenter ? -depth : touch->mesh.length_unit;
  if (!touch->FieldOf(place, unit * n, &along_n_)) return false;
  // Without friction only the part along the normal presses.
  const bool slides = touch->law == ContactLaw::kFrictionless;
  if (!slides && !touch->FieldOf(place, std::abs(unit) * t, &along_t_)) return false;
  for (const int axis : {0, 1}) {
    auto& along = axis == 0 ? along_x_ : along_y_;
    along.resize(along_n_.size());
    for (std::size_t i = 0; i < along.size(); ++i) {
      along[i] = n[axis] / unit * along_n_[i];
      if (!slides) along[i] += t[axis] / std::abs(unit) * along_t_[i];
    }
  }
  return true;
}

void IndentationCheck::Expect(const BoundaryPlace& place,
                              const ObjectRegistrationMonitor::Bar& tool,
                              const Eigen::Isometry3d& X_SO, const CameraView& view,
                              TouchModel* touch, ObjectRegistrationMonitor* watch) noexcept {
  const bool near = place.gap < kNear * view.pixel();
  const double depth = touch->indenter ? std::max(-place.gap, kFirst * view.pixel()) : 0;
  const bool deepens = std::abs(depth - depth_) > kDeepens * depth_;
  if (near && place.element == element_ && !deepens) return;
  element_ = -1;
  watch->ForgetDent();
  if (!near || !Take(place, depth, touch)) return;
  const double element =
      touch->mesh.elements[static_cast<std::size_t>(place.element)].length() / view.pixel();
  const Eigen::Vector2d p_I = view.ToImage(X_SO * Planar(place.p_O));
  watch->SetDent(along_x_, along_y_, {p_I, tool.width, element});
  sigma_ = kModel + kMesh * element / (element + tool.width);
  element_ = place.element;
  depth_ = depth;
}

bool IndentationCheck::Agrees(const Prediction& prediction,
                              const ObjectSighting& seen) const noexcept {
  if (!seen.dent_known) return true;
  const double sigma2 = kFloor * kFloor + sigma_ * sigma_ * prediction.dent_O.squaredNorm() +
                        prediction.sigma_px * prediction.sigma_px;
  const Eigen::Matrix2d C = seen.dent_covariance + sigma2 * Eigen::Matrix2d::Identity();
  const Eigen::Vector2d error = seen.dent_O - prediction.dent_O;
  return error.dot(C.inverse() * error) < kSigmas * kSigmas;
}

void IndentationCheck::Check(const Prediction& prediction, const ObjectSighting& seen,
                             ContactEstimate* felt) noexcept {
  if (!seen.known) return felt->Fail(FailedCheck::kRegistration, "the object's edge is not found");
  if (seen.motion.shift.norm() > Limits::kMostShift ||
      std::abs(seen.motion.angle) > Limits::kMostTurn) {
    felt->Fail(FailedCheck::kCameraMotion, "the image has moved too far");
  }
  if (std::abs(seen.motion.growth) > Limits::kMostGrowth) {
    felt->Fail(FailedCheck::kScale, "the image has grown or shrunk: zoom");
  }
  const bool rough = prediction.sigma_px > std::max(kRoughTip, kRough * prediction.dent_O.norm());
  const bool blurred =
      seen.sharpness < Limits::kSharpness || seen.sharpness_at_rest < Limits::kSharpAtRest;
  if (blurred || rough || seen.exposure > Limits::kOverexposed) {
    felt->Fail(FailedCheck::kPicture, "the image is blurred, overexposed or too noisy at the tip");
  }
  if (seen.apart > kMostApart) felt->Fail(FailedCheck::kDent, kOtherEdge);
  distrust_ = Agrees(prediction, seen) ? std::max(0, distrust_ - 1) : kDistrust;
  const bool confirmed = seen.dent_known || prediction.dent_O.norm() < Limits::kSmallDent;
  unconfirmed_ = confirmed ? 0 : unconfirmed_ + 1;
  if (distrust_ > 0 || unconfirmed_ > kUnconfirmed) {
    felt->Fail(FailedCheck::kDent, kOtherDent);
  }
  if (!confirmed && prediction.covered > kCovered) {
    felt->Fail(FailedCheck::kTipCovered, "a part of the tip is hidden");
  }
}

}  // namespace palpate
