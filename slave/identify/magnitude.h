// RequirePossible checks whether the numbers of a test can be those of a solid. If not, a unit is
// wrong: it changes them by a factor of 100 or more.
#pragma once

#include <string>

#include "slave/identify/material_test.h"
#include "slave/identify/specimen_table.h"

namespace palpate::identify {

// Young's modulus [Pa]: from mucus and gels to diamond.
inline constexpr double kMinModulus = 10, kMaxModulus = 1e12;
// Range of the modulus of soft solids [Pa]: from organs, which flatten under their own weight if
// they are softer [derived: density * g * height of 100 mm = 1 kPa], to hard rubber. A table that
// names no unit must be of these.
inline constexpr double kMinSoft = 1e3, kMaxSoft = 1e8;
// Range of the modulus of most samples [Pa]: from liver and soft gels to rubbers of Shore A 80
// [paper: moduli of tissues and elastomers in common tables]. Outside of it a remark suggests to
// check the unit.
inline constexpr double kMinUsual = 3e3, kMaxUsual = 1e7;
// Nominal stress of soft solids [Pa]: the strength of the strongest elastomers, cast polyurethanes
// [paper: data sheets, 40 to 60 MPa].
inline constexpr double kStrength = 6e7;
// Smallest accepted largest strain of solids below 1 GPa: up to 1 % the seating of the ends is as
// large as the strain [paper: ISO 7743 evaluates from 10 % on]. Largest strain of solids harder
// than soft ones, which yield or break before.
inline constexpr double kMinStrain = 0.01, kStiff = 1e9, kYieldStrain = 0.05;
// Largest stretch without a remark: silicones reach 18 [-].
inline constexpr double kLongStretch = 12;

// Returns a remark on numbers that are rare; empty if there is none. Throws InputError naming the
// value, what is accepted and the options that give units.
std::string RequirePossible(const MaterialTest& test);
std::string RequirePossible(const RelaxationTable& table);

}  // namespace palpate::identify
