// A plate whose shape under its contacts can be asked for anywhere.
#pragma once

#include "slave/mechanics/deformation_model.h"

namespace palpate {

class PlateSurface : public DeformationModel {
 public:
  // Displacement along z [m] at (x, y) on the plate, frame O [m], under the contacts of the last
  // Respond; zero where it failed. No allocation.
  [[nodiscard]] virtual double Displacement(const Eigen::Vector2d& p_O) noexcept = 0;
  [[nodiscard]] virtual double radius() const = 0;     // a [m]
  [[nodiscard]] virtual double thickness() const = 0;  // t [m]
};

}  // namespace palpate
