// Titles of table columns: a name and a unit, in brackets or after the name.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

enum class Quantity : std::uint8_t { kNumber, kLength, kForce, kStress, kTime };
// Returns for example `a length in m mm um ...`, with the known units.
std::string InWords(Quantity quantity);

struct Unit {
  std::string_view name;
  Quantity quantity = Quantity::kNumber;
  double to_si = 1;
};
// Returns the unit named by `word`, with or without brackets; nullopt: unknown.
std::optional<Unit> FindUnit(std::string_view word);

struct ColumnTitle {
  std::string name;                    // without the unit
  std::optional<double> to_si{};       // factor of the title's unit; nullopt: no unit
  std::optional<Quantity> quantity{};  // quantity of the unit
  std::string unknown_unit{};          // text of an unknown unit
};
// Splits titles such as `Load (N)` and `Strain (Extension) (%)`.
ColumnTitle SplitTitle(std::string_view title);
// Also splits `Force / N`, `Stress, psi`, `P_MPa` and `Kraft in N`; the name becomes lower case.
ColumnTitle SplitFreeTitle(std::string_view title);

}  // namespace palpate
