// Whether numbers of a test can be those of a soft solid. If not, their unit is wrong: a wrong unit
// changes them by a factor of 100 or more.
#pragma once

#include "slave/identify/material_test.h"
#include "slave/identify/test_table.h"

namespace palpate::identify {

// Young's modulus [Pa]. An organ of 100 mm that is softer flattens under its own weight [derived:
// density * g * height = 1 kPa]. The hardest object of the scenes is the rubber of 27 MPa [paper:
// C].
inline constexpr double kLeastModulus = 1e3, kMostModulus = 1e8;
// Nominal stress [Pa]: the strength of the strongest elastomers, cast polyurethanes [paper: data
// sheets, 40 to 60 MPa].
inline constexpr double kStrength = 6e7;
// Largest strain and stretch [-]. Up to 1 % the seating of the ends is as large as the strain
// [paper: ISO 7743 evaluates from 10 % on]. The softest silicones break at a stretch of 9 to 11
// [paper: data sheets of Ecoflex, 800 to 1000 %].
inline constexpr double kLeastStrain = 0.01, kBreakingStretch = 12;

// Throws InputError naming the value, what is accepted and the options that give units.
void RequirePossible(const MaterialTest& test);
void RequirePossible(const RelaxationTable& table);

}  // namespace palpate::identify
