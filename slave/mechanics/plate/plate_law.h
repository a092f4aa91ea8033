// Errors of von Karman's plate relative to solid rubber sheets, which limit its range by position,
// depth and thickness.
//
// The solid: neo-Hookean, nu 0.45, clamped at radius a, under a uniform round load of diameter a /
// 10; t of a / 80 to a / 10, w up to a / 4 at the centre and to a / 8 beside it, up to 0.8 of the
// radius (tests/slave/reference/membrane/membrane_laws_test.cpp). Bending without shear makes the
// plate too stiff if it is thick or fixed near the load; moderate rotations and linear elasticity
// do so where it is steep. The errors are smaller for wider loads and larger for narrower ones.
#pragma once

namespace palpate::plate {

struct Indentation {
  double place = 0;        // of the load [radii], below 1
  double deflection = 0;   // under the load, relative to the radius
  double slenderness = 0;  // t / a
};

// Excess of the plate's force at the same deflection, relative to the solid's force:
//   7.2 (t/a)^2 / (1 - p^2)^2 + (1.95 + 90 t/a) (w/a)^2 / (1 - p^2)^(3/4).
// Up to 0.15 it is within 0.03 of the measured excess.
double ExcessAtDepth(const Indentation& indentation) noexcept;

// Returns the deflection at the centre, relative to the radius, at which the excess is `excess`; 0:
// the plate is too thick for any deflection.
double DeflectionOfExcess(double excess, double slenderness) noexcept;

// Returns one standard deviation, relative to the force, of the error that the plate's law causes
// in a force estimated from the shape around the load:
//   2.5 (t/a)^2 / (1 - p^2)^3 and 1.25 (w/a)^2 / (1 - p^2), whose signs may be opposite.
// The measured errors are within twice this value wherever the plate's answer is valid.
double LawsSigma(const Indentation& indentation) noexcept;

// Largest |w| / t at a radius [radii] up to which modes of order 12 find the force from the shape
// as those of order 20 do, within 1 %: 6 (1 - p^2)^2.
double ResolvedDeflection(double place) noexcept;

}  // namespace palpate::plate
