// Words of the force test card.
#pragma once

#include <array>
#include <numbers>
#include <string>
#include <vector>

#include "slave/commands/verify/force_card.h"

namespace palpate {

inline constexpr double kDegree = std::numbers::pi / 180;  // [rad]

inline constexpr std::array<const char*, 3> kAxisNames{"x", "y", "z"};

// `x, z`.
std::string AxisNames(const std::vector<int>& axes);
// Which known axis is reported as which, or where the sign is reversed.
std::string RelationWords(const AxisRelation& relation, const std::vector<int>& axes);
// `1.012 (0.998 to 1.027)`, times `scale`.
std::string Words(const Interval& interval, const char* unit = "", double scale = 1,
                  int digits = 3);
// Whether an interval lies inside `low` to `high`, outside, or across an end.
Finding Judged(const Interval& interval, double low, double high);

// A mistake with a unit multiplies reported forces by `factor`.
struct UnitMistake {
  double factor = 1;
  const char* words = "";
};
// The mistake that explains a force that is multiplied by `gain` to within a factor of 1.5; the
// factor 1: none.
UnitMistake UnitOf(double gain);

// What is likely wrong with a set-up of this card.
std::vector<std::string> CausesOf(const ForceCard& card, const SetUp& set_up);

}  // namespace palpate
