// `plate`: a clamped circular plate at small deflection, by its Green's function in closed form
// (paper C, eqs. 1 and 2, with the part lost in the scan).
#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/plate_surface.h"

namespace palpate {

// Thin plate, moderate slopes, no stretching: the force is low by 1.8 % at |w| = 0.2 t, 10 %
// at 0.5 t and 30 % at t, and is marked kExtrapolated beyond 0.5 t.
//
// Contacts are points (width 0), discs of diameter `width` under a uniform load, whose displacement
// is that of the centre, as input and output, or rigid flat faces (pressed_places.h); positions in
// |z| <= t / 2, on the disc. Only z components are allowed: others must be 0. O(S^2), with a new
// set of displaced positions or another part of a face that touches O(S^3); a face counts for 24.
class PlateModel final : public PlateSurface {
 public:
  struct Params {
    double radius = 0;         // a [m], > 0
    double thickness = 0;      // t [m], 0 < t <= a / 10
    double young_modulus = 0;  // E [Pa], > 0
    double poisson_ratio = 0;  // nu [-], -1 < nu <= 0.5
    double range = 0.5;        // largest |w| / t before `extrapolated` [-], > 0
  };

  // Throws std::invalid_argument naming the parameter, its value and what is accepted.
  explicit PlateModel(const Params& params);

 private:
  bool TryRespond(std::span<const Contact> contacts, std::span<ContactResponse> responses) override;
  void Prepare();
  bool SolveForces();
  [[nodiscard]] double DisplacementAt(const Eigen::Vector2d& x) noexcept override;

  Params params_;
  double force_unit_ = 0;                    // D / a: deflects by about a [N]
  std::vector<plate::PressedPlace> places_;  // of the contacts, one after another
  std::vector<Eigen::Index> firsts_;         // the first place of each contact, and the end
  // Deflection at the row's place under a unit load at the column's place.
  Eigen::MatrixXd compliance_;
  Eigen::VectorXd forces_, deflections_;  // at the places, nondimensional
  plate::PressedPlaces pressed_;
  std::vector<double> values_;  // of the contacts with unknown forces
};

}  // namespace palpate
