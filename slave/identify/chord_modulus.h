// Young's modulus as one number of a curve that is not straight.
#pragma once

#include <optional>
#include <string>

#include "slave/identify/material_test.h"

namespace palpate::identify {

// The chord modulus: slope of nominal stress over nominal strain, from a straight line through the
// rows between 10 and 20 % strain, at which ISO 7743 states compression moduli of rubber; a shorter
// curve is used completely. It is divided by the factor by which bonded ends stiffen the specimen
// at rest. Above a few percent of strain a specimen is in full contact with the plates, and up to
// 20 % most soft solids are nearly linear.
struct ChordModulus {
  double modulus = 0, sigma = 0;  // [Pa]; sigma from the scatter about the line
  double from = 0, to = 0;        // sizes of strain [-]
  // Relative amount by which the line from rest with this slope exceeds the stress at `to` [-].
  double excess = 0;
  bool compression = false;
};
inline constexpr double kChordFrom = 0.1, kChordTo = 0.2;

// nullopt: not a uniaxial test, or too few rows there.
std::optional<ChordModulus> ChordModulusOf(const MaterialTest& test);

}  // namespace palpate::identify
