#include "slave/tactile/localise/finger_surface.h"

namespace palpate {
namespace {

constexpr double kRounding =
    1e-12;  // of the size at hand: what is nearer than this has no direction

// What lies outward of the sphere's centre, or of the cylinder's axis behind it.
Eigen::Vector3d Outward(const Eigen::Vector3d& p_F) {
  return {p_F.x() >= 0 ? p_F.x() : 0, p_F.y(), p_F.z()};
}

}  // namespace

std::optional<Eigen::Vector3d> FingerSurface::Project(const Eigen::Vector3d& c_F) const noexcept {
  const Eigen::Vector3d outward = Outward(c_F);
  const double length = outward.stableNorm();
  const double size = c_F.x() >= 0 ? radius : radius - c_F.x();
  if (!c_F.allFinite() || !(length > kRounding * size)) return std::nullopt;
  const Eigen::Vector3d from_axis = radius * outward.stableNormalized();
  return Eigen::Vector3d(c_F.x() >= 0 ? from_axis.x() : c_F.x(), from_axis.y(), from_axis.z());
}

Eigen::Vector3d FingerSurface::Normal(const Eigen::Vector3d& p_F) const noexcept {
  return Outward(p_F).stableNormalized();
}

}  // namespace palpate
