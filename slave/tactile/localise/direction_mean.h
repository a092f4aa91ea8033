// A contact from intensities by averaging directions: an improved form of the paper's equations
// (1) to (4).
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "slave/tactile/localise/electrode_layout.h"
#include "slave/tactile/localise/finger_surface.h"
#include "slave/tactile/localise/intensity.h"

namespace palpate {

// Every electrode is first projected on the finger's surface (equation 4), and what is averaged is
// its outward normal there, weighted by intensity:
//
//   n = sum I_i n_i / |sum I_i n_i|
//
// The paper averages places inside the core and projects their mean. There electrodes far behind
// pull the mean backwards by their whole distance, though they say no more of the direction than
// near ones.
struct ContactDirection {
  Eigen::Vector3d n_F{0, 0, 0};  // unit
  double axis_x = 0;             // where the axis is met, the intensities' mean [m], <= 0
};

class DirectionMean {
 public:
  // Throws std::invalid_argument: an electrode without a direction.
  DirectionMean(const ElectrodeLayout& layout, double radius);

  // nullopt: no intensity, or directions that cancel.
  [[nodiscard]] std::optional<ContactDirection> Mean(const Intensities& intensities) const noexcept;

  // The place of the surface where a contact with this outward normal is. The tip's sphere has one
  // for every elevation above the plane x = 0; the cylinder has the same normal all along, so that
  // there the mean along the axis decides. Between elevation 0 and kBlend one passes into the
  // other.
  [[nodiscard]] Eigen::Vector3d PlaceOf(const ContactDirection& direction) const noexcept;

  [[nodiscard]] const FingerSurface& surface() const noexcept { return surface_; }

 private:
  FingerSurface surface_;
  std::array<Eigen::Vector3d, kElectrodeCount> n_F_;
  std::array<double, kElectrodeCount> axis_x_{};
};

}  // namespace palpate
