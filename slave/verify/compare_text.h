// Words of a comparison of forces.
#pragma once

#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "slave/verify/compare_forces.h"

namespace palpate {

inline constexpr double kDegree = std::numbers::pi / 180;  // [rad]

inline constexpr std::array<const char*, 3> kAxisNames{"x", "y", "z"};

// `x, z`.
std::string AxisNames(const std::vector<int>& axes);
// Returns which measured axis is estimated as which, or where the sign is reversed.
std::string RelationWords(const AxisRelation& relation, const std::vector<int>& axes);
// `1.012 (0.998 to 1.027)`, times `scale`.
std::string Words(const Interval& interval, const char* unit = "", double scale = 1,
                  int digits = 3);

// A mistake with a unit multiplies estimated forces by `factor`.
struct UnitMistake {
  double factor = 1;
  const char* words = "";
};
// Returns the unit mistake whose factor is in the interval `gain`; factor 1: none.
UnitMistake UnitOf(const Interval& gain);

// Returns the likely causes of a wrong result.
std::vector<std::string> CausesOf(const ForceComparison& comparison, const ForceSource& source);

}  // namespace palpate
