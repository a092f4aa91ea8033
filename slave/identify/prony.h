// The Prony series describes how stress relaxes at constant strain: a sum of exponentials.
//
//   stress(t) = integral of G(t - s) d strain / ds ds,   G(t) = G_inf + sum of G_i exp(-t / tau_i)
//
// There are two time constants per decade between the shortest step and the whole record; the
// moduli are found by non-negative least squares. Terms with zero modulus, and those whose 95 %
// interval includes zero, are left out.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "slave/identify/specimen_table.h"

namespace palpate::identify {

struct PronyTerm {
  double modulus = 0, sigma = 0;  // [Pa]
  double time = 0;                // [s]
};
struct PronyFit {
  double equilibrium = 0, sigma = 0;  // G_inf [Pa]: modulus at the end of the record
  std::vector<PronyTerm> terms;       // from the fastest on
  double instant = 0;                 // G_inf + sum of G_i [Pa]
  double rms = 0;                     // relative to the peak [-]
  int dropped = 0;                    // terms whose interval includes zero

  [[nodiscard]] double At(double time) const;  // G(time) [Pa]
};

// Fits all records of one material, with any strain histories. Throws InputError: no strain; shear
// and other strains together; records that cannot separate fading from a curved stress-strain law,
// because the strain only rises at one rate, without a hold or a return.
PronyFit FitProny(const std::vector<RelaxationTable>& tables);

}  // namespace palpate::identify
