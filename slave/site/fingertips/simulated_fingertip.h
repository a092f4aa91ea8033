// A fingertip of our own in the manner of the BioTac: skin over conductive fluid over nineteen
// electrodes, laid out as SimulatedLayout says. What it reads is never computed by what estimates
// from it.
#pragma once

#include <cstdint>
#include <memory>

#include <Eigen/Core>

#include "slave/capture/tactile_frame.h"

namespace palpate {

// What presses on the fingertip. Frame F.
struct FingertipLoad {
  Eigen::Vector3d p_F{0, 0, 0};  // on its surface [m]
  Eigen::Vector3d f_F{0, 0, 0};  // of the object on the fingertip [N]
  double radius = 0;             // of the contact area [m], >= 0
};

class SimulatedFingertip {
 public:
  // `seed` decides rest values, noise and drift: another one is another start.
  explicit SimulatedFingertip(std::uint32_t seed);
  ~SimulatedFingertip();
  SimulatedFingertip(SimulatedFingertip&&) noexcept;
  SimulatedFingertip& operator=(SimulatedFingertip&&) noexcept;
  // The reading `seconds` after the last one, under `load` (null: nothing touches). The skin
  // relaxes, the fluid flows, the counts drift.
  FingerReading Sample(const FingertipLoad* load, double seconds) noexcept;

 private:
  struct Skin;
  std::unique_ptr<Skin> skin_;
};

}  // namespace palpate
