// The clamped von Karman plate by Ritz's method in all three displacements with Cartesian
// polynomials: no Airy function, no Fourier modes, no Green's function. Loads act over discs on the
// x axis. Values are nondimensional as in round_press.h.
#pragma once

namespace palpate::plate {

// Deflection at the centre (place, 0) of a disc under a load of `force`. The deflection is (1 -
// r^2)^2 times a polynomial of `degree`; the displacements in the plane are (1 - r^2) times a
// polynomial of `degree` + 4.
double RitzDeflection(double nu, double place, double load_radius, double force, int degree);

}  // namespace palpate::plate
