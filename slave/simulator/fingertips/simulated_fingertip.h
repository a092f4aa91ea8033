// A simulated fingertip similar to the BioTac: skin over conductive fluid over nineteen electrodes,
// arranged as in SimulatedLayout. No estimator shares its computation.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"

namespace palpate {

// Loads on the fingertip. Frame F.
struct FingertipLoad {
  Eigen::Vector3d p_F{0, 0, 0};  // on its surface [m]
  Eigen::Vector3d f_F{0, 0, 0};  // of the object on the fingertip [N]
  double radius = 0;             // of the contact area [m], >= 0
};

class SimulatedFingertip {
 public:
  // `seed` decides the baseline, noise and drift: another one is another start.
  explicit SimulatedFingertip(std::uint32_t seed);
  ~SimulatedFingertip();
  SimulatedFingertip(SimulatedFingertip&&) noexcept;
  SimulatedFingertip& operator=(SimulatedFingertip&&) noexcept;
  // Returns the reading `seconds` after the last one, under `load` (null: no contact). Includes
  // relaxation of the skin, flow of the fluid and drift of the counts.
  FingerReading Sample(const FingertipLoad* load, double seconds) noexcept;

 private:
  struct Skin;
  std::unique_ptr<Skin> skin_;
};

}  // namespace palpate

namespace palpate::simulation {

// The skin of the simulated fingertip as points with an area. Frame F. The electrodes' positions on
// the skin come first and have no area; the others share the half sphere at the tip and the
// cylinder behind it.
struct SkinSurface {
  static constexpr std::size_t kCylinderRings = 8, kSphereRings = 5, kAround = 16;
  static constexpr std::size_t kCount = kElectrodeCount + (kCylinderRings + kSphereRings) * kAround;
  std::array<Eigen::Vector3d, kCount> p_F;  // [m]
  std::array<double, kCount> area{};        // [m^2]
  // Mobility of the skin, 0 (bonded to the nail on the back) to 1.
  std::array<double, kCount> freedom{};
  // Tendency to bulge, 0 to 1: more at the sides than on the pad.
  std::array<double, kCount> bulge{};
};

SkinSurface MakeSkinSurface();

inline constexpr double kSkinRadius = 7e-3;  // of sphere and cylinder (paper B, equation 4) [m]

}  // namespace palpate::simulation
