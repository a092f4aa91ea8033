// What a membrane is made of, from presses whose force and air pressure were measured.
//
// Two steps, because the numbers show in different things. How tight the skin is, T / (E h), shows
// in the shape of the deflection: a tight skin makes a pointed indentation, a slack one that stands
// by its curvature a wide one with a rim; forces take no part in it. How stiff it all is shows in
// the force alone.
#pragma once

#include <span>
#include <vector>

#include "slave/pipeline/press/membrane_press.h"

namespace palpate {

// Stiffness of a real membrane from contacts with a known force. One contact: the force from its
// deflection at the model's own stiffness, the part of the air (MembranePress::Reading), and the
// measured force.
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

// Least squares. Throws std::invalid_argument: fewer contacts than one more than the unknowns, or
// contacts that do not determine the stiffness (none, or all the same if there is an offset).
StiffnessFit FitStiffness(std::span<const KnownPress> presses, bool with_offset);

struct PressSample {
  std::vector<SurfacePoint> points_O;
  double pressure_rise = 0;  // against the rest frame [Pa]
  double force = 0;          // of the tool on the membrane, inward [N]
};

struct IdentifiedMembrane {
  // The membrane at its measured stiffness; its pressure is the one that balances the tension.
  InflatedMembrane::Params params;
  double tension_share = 0;  // T / (E h) [-]
  double misfit = 0;         // of the deflections, rms over the samples in contact [m]
  StiffnessFit fit;          // of modulus 1 N/m
  int in_contact = 0;        // samples whose deflection exceeds the noise
};

// `with_offset`: a constant force in addition to the contact is allowed; samples without contact
// then determine it. Throws std::invalid_argument: fewer than three samples in contact, or data
// that InflatedMembrane and FitStiffness reject.
IdentifiedMembrane IdentifyMembrane(const MembraneShape& shape, double poisson_ratio,
                                    const MembranePress::Params& press,
                                    std::span<const PressSample> samples, bool with_offset);

}  // namespace palpate
