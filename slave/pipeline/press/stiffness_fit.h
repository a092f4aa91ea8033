// How stiff a membrane really is, from presses whose force is known.
#pragma once

#include <span>

namespace palpate {

// One press: what its deflection says at the model's own stiffness and what the air adds
// (MembranePress::Reading), beside the force measured.
struct KnownPress {
  double own_force = 0;  // [N]
  double air_force = 0;  // A dp [N]
  double force = 0;      // measured, positive: presses [N]
};

// force = stiffness * own_force + air_force + offset.
struct StiffnessFit {
  double stiffness = 0;        // times the model's own [-]
  double offset = 0;           // force at which the deflection begins [N]
  double sigma_stiffness = 0;  // by what the presses scatter, [-]
  double scatter = 0;          // rms of measured less fitted [N]
};

// Least squares. Throws std::invalid_argument: fewer presses than unknowns and one more, or presses
// that do not tell the stiffness (none, or all the same where there is an offset).
StiffnessFit FitStiffness(std::span<const KnownPress> presses, bool with_offset);

}  // namespace palpate
