// What a membrane is like at rest, from pictures under known loads: its tension, the pressure that
// inflates it, its modulus.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "slave/mechanics/plate/plate_large_model.h"

namespace palpate {

// Points of the membrane while a known load presses it; none at rest.
struct MembraneState {
  Eigen::Vector2d p_O{0, 0};  // centre of the load [m]
  double force = 0;           // along z, of the tool on the membrane [N]: negative presses
  double force_sigma = 0;     // one sigma of it [N]
  double width = 0;           // its diameter [m]
  std::vector<Eigen::Vector2d> points_O;  // [m]
  std::vector<double> heights;  // above the plane of the rim, along z [m]; of a flat one: the
                                // displacement
  std::vector<double> sigmas;   // [m], > 0
};

struct MembraneUnknowns {
  bool pressure = false;  // inflated; else flat at rest
  bool modulus = false;   // E too, besides the tension: from two loads of clearly different size
};

// All errors one sigma, linear at the answer.
struct MembraneIdentity {
  bool identified = false;
  double prestress = 0, prestress_sigma = 0;          // tension N0 of the flat membrane [N/m], >= 0
  double pressure = 0, pressure_sigma = 0;            // from inside, along z [Pa]
  double young_modulus = 0, young_modulus_sigma = 0;  // [Pa]
  double residual = 0;                                // rms of (measured - fitted) / sigma
  std::string reason;                                 // where not identified, one sentence
};

// Least squares over all points of all states through the von Karman plate in its modes:
// tension at rest, uniform pressure as a load over the whole plate, and stretching act together,
// so that the pressure of a bulge is not taken for its tension. For thin membranes this is the
// bulge equation p = 4 N h / a^2, N = N0 + c E t h^2 / a^2 with c about 0.8 (h: height of the
// centre; Small and Nix 1992), and under a small load F the compliance ln(a / r) / (2 pi N); here
// bending and the curved shape's own stiffness count too. The pressure is taken to stay while the
// membrane is pressed: a vented or large chamber.
//
// Not identified, with the reason: less said by the points than is asked; a load so large that
// stretching hides the tension; one that does not stand out of the noise enough. The tension
// counts as known where its sigma is below half of it or of 16 D / a^2, the tension that matters
// to a plate of rigidity D. Takes a second. `plate`: its order is that of the modes, 16 is well
// chosen; its prestress is ignored; its modulus is kept
// unless unknown, then it is where the search begins. Throws std::invalid_argument: states without
// points, of unequal sizes, not finite, sigmas not > 0, points off the plate; see PlateLargeModel.
MembraneIdentity IdentifyMembrane(const PlateLargeModel::Params& plate,
                                  std::span<const MembraneState> states,
                                  const MembraneUnknowns& unknowns = {});

}  // namespace palpate
