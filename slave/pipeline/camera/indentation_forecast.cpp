#include "slave/pipeline/camera/indentation_forecast.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace palpate {
namespace {

// Distance from the surface within which an indentation is expected [px].
constexpr double kNearDistance = 15;
// Relative sigma of a computed indentation [-]: part of the model, and part that grows with the
// element length relative to the tool's width.
constexpr double kModel = 0.05, kMesh = 0.1;
// Depth for which a round tool's indentation is computed before it touches [px]. [by definition]
constexpr double kFirst = 1;
// Relative change of a round tool's depth after which its indentation is computed again [-].
constexpr double kDeepens = 0.1;

}  // namespace

// Computes the displacements along the normal and, for a sticking contact, in the tangential
// direction.
bool IndentationForecast::Take(const BoundaryPlace& place, double depth,
                               TouchModel* touch) noexcept {
  const Eigen::Vector3d n = Planar(place.normal_O), t(-n.y(), n.x(), 0);
  const double unit = touch->is_round() ? -depth : touch->mesh.length_unit;
  if (!touch->FieldOf(place, unit * n, &along_n_)) return false;
  // Without friction only the normal component is transmitted.
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

void IndentationForecast::Expect(const BoundaryPlace& place,
                                 const ObjectRegistrationMonitor::Bar& tool,
                                 const Eigen::Isometry3d& X_SO, const CameraView& view,
                                 TouchModel* touch, ObjectRegistrationMonitor* watch) noexcept {
  const bool near = place.gap < kNearDistance * view.pixel();
  const double depth = touch->is_round() ? std::max(-place.gap, kFirst * view.pixel()) : 0;
  const bool deepens = std::abs(depth - depth_) > kDeepens * depth_;
  if (near && place.element == element_ && !deepens) return;
  element_ = -1;
  watch->ForgetIndentation();
  if (!near || !Take(place, depth, touch)) return;
  const double element =
      touch->mesh.elements[static_cast<std::size_t>(place.element)].length() / view.pixel();
  const Eigen::Vector2d p_I = view.ToImage(X_SO * Planar(place.p_O));
  watch->SetIndentation(along_x_, along_y_, {p_I, tool.width, element});
  sigma_ = kModel + kMesh * element / (element + tool.width);
  element_ = place.element;
  depth_ = depth;
}

}  // namespace palpate
