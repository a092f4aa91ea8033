// BondedCylinderFactor computes how much stiffer a short cylinder is if its ends cannot widen.
#pragma once

namespace palpate::identify {

// Force over that of free ends at the same small compression, by axisymmetric finite elements
// (quadratic displacement, linear discontinuous pressure), within 0.3 %. `slenderness`: diameter
// over height, 0.01 to 20; -0.9 <= nu <= 0.5. Throws std::invalid_argument. At nu = 0.5 it is not
// far from 1 + slenderness^2 / 8 (Gent and Lindley 1959), which is for flat discs.
double BondedCylinderFactor(double slenderness, double nu);

}  // namespace palpate::identify
