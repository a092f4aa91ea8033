#include "slave/site/fingertips/skin_surface.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "slave/tactile/localise/electrode_layout.h"

namespace palpate::site {
namespace {

using Eigen::Vector3d;

constexpr double kLength = 16e-3;  // of the cylinder that the skin covers [m]
// Upward normal above which the skin begins to be, and is wholly, bonded to the nail.
constexpr double kNailBegins = 0.1, kNail = 0.6;
// Of the pad's middle against its sides. Foam recording: the electrodes of the sides rise two to
// ten times as much as those of the middle.
constexpr double kPadBulge = 0.15;

double FreedomAt(const Vector3d& n_F) {
  return std::clamp((kNail - n_F.z()) / (kNail - kNailBegins), 0.0, 1.0);
}

double BulgeAt(const Vector3d& n_F) {
  return FreedomAt(n_F) * (kPadBulge + (1 - kPadBulge) * n_F.y() * n_F.y());
}

}  // namespace

SkinSurface MakeSkinSurface() {
  SkinSurface skin;
  std::size_t count = 0;
  const auto add = [&](const Vector3d& p_F, const Vector3d& n_F, double area) {
    skin.p_F[count] = p_F;
    skin.area[count] = area;
    skin.freedom[count] = FreedomAt(n_F);
    skin.bulge[count] = BulgeAt(n_F);
    ++count;
  };
  const FingerSurface finger{kSkinRadius};
  const ElectrodeLayout layout = SimulatedLayout(kSkinRadius);
  for (const Vector3d& core : layout.p_F) {
    const Vector3d p = finger.Project(core).value_or(Vector3d(kSkinRadius, 0, 0));
    add(p, finger.Normal(p), 0);
  }
  constexpr double kTurn = 2 * std::numbers::pi / static_cast<double>(SkinSurface::kAround);
  for (std::size_t around = 0; around < SkinSurface::kAround; ++around) {
    const double azimuth = (static_cast<double>(around) + 0.5) * kTurn;
    const Vector3d n(0, std::sin(azimuth), -std::cos(azimuth));
    const double ring = kLength / static_cast<double>(SkinSurface::kCylinderRings);
    for (std::size_t i = 0; i < SkinSurface::kCylinderRings; ++i) {
      const double x = -(static_cast<double>(i) + 0.5) * ring;
      add(kSkinRadius * n + Vector3d(x, 0, 0), n, ring * kTurn * kSkinRadius);
    }
    // Rings of equal height have equal areas on a sphere (Archimedes).
    const double height = 1.0 / static_cast<double>(SkinSurface::kSphereRings);
    for (std::size_t i = 0; i < SkinSurface::kSphereRings; ++i) {
      const double x = (static_cast<double>(i) + 0.5) * height;
      const Vector3d n_tip = std::sqrt(1 - x * x) * n + Vector3d(x, 0, 0);
      add(kSkinRadius * n_tip, n_tip, height * kTurn * kSkinRadius * kSkinRadius);
    }
  }
  return skin;
}

}  // namespace palpate::site
