// Titles of table columns: a name and a unit in brackets or behind it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

enum class Quantity : std::uint8_t { kNumber, kLength, kForce, kStress, kTime };
// `a length in m mm um ...`, with the units that are understood.
std::string InWords(Quantity quantity);

struct Unit {
  std::string_view name;
  Quantity quantity = Quantity::kNumber;
  double to_si = 1;
};
// The unit that `word` names, with or without brackets; nullopt: none that is understood.
std::optional<Unit> FindUnit(std::string_view word);

struct ColumnTitle {
  std::string name;                    // without the unit
  std::optional<double> to_si{};       // factor of the unit it names; nullopt: it names none
  std::optional<Quantity> quantity{};  // quantity of the unit
  std::string unknown_unit{};          // text of an unknown unit
};
// `Load (N)`, `Strain (Extension) (%)`.
ColumnTitle SplitTitle(std::string_view title);
// Also `Force / N`, `Stress, psi`, `P_MPa`, `Kraft in N`; the name in small letters.
ColumnTitle SplitFreeTitle(std::string_view title);

}  // namespace palpate
