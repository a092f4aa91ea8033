// The skin of the simulated fingertip as points that carry an area each.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"

namespace palpate::site {

// Frame F. The electrodes' places on the skin come first and carry no area; the others divide the
// half sphere at the tip and the cylinder behind it among themselves.
struct SkinSurface {
  static constexpr std::size_t kCylinderRings = 8, kSphereRings = 5, kAround = 16;
  static constexpr std::size_t kCount = kElectrodeCount + (kCylinderRings + kSphereRings) * kAround;
  std::array<Eigen::Vector3d, kCount> p_F;  // [m]
  std::array<double, kCount> area{};        // [m^2]
  // How free the skin is to move, 0 (bonded to the nail on the back) to 1.
  std::array<double, kCount> freedom{};
  // How readily it bulges, 0 to 1: more at the sides than on the pad.
  std::array<double, kCount> bulge{};
};

SkinSurface MakeSkinSurface();

inline constexpr double kSkinRadius = 7e-3;  // of sphere and cylinder (paper B, equation 4) [m]

}  // namespace palpate::site
