#include "shared/text/column_title.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "shared/text/text.h"

namespace palpate {
namespace {

constexpr double kGravity = 9.80665;             // standard gravity [m/s^2]
constexpr double kInch = 0.0254;                 // [m]
constexpr double kPoundForce = 4.4482216152605;  // [N]
constexpr double kPsi = kPoundForce / (kInch * kInch);

// Units in lower case; FindUnit handles units that differ only in case.
constexpr std::array kUnits{
    Unit{"pa", Quantity::kStress, 1},
    Unit{"kpa", Quantity::kStress, 1e3},
    Unit{"mpa", Quantity::kStress, 1e6},
    Unit{"gpa", Quantity::kStress, 1e9},
    Unit{"n/mm2", Quantity::kStress, 1e6},
    Unit{"n/mm^2", Quantity::kStress, 1e6},
    Unit{"n/cm2", Quantity::kStress, 1e4},
    Unit{"n/m2", Quantity::kStress, 1},
    Unit{"n/m^2", Quantity::kStress, 1},
    Unit{"kn/m2", Quantity::kStress, 1e3},
    Unit{"bar", Quantity::kStress, 1e5},
    Unit{"mbar", Quantity::kStress, 1e2},
    Unit{"psi", Quantity::kStress, kPsi},
    Unit{"ksi", Quantity::kStress, 1e3 * kPsi},
    Unit{"kgf/cm2", Quantity::kStress, 1e4 * kGravity},
    Unit{"kgf/mm2", Quantity::kStress, 1e6 * kGravity},
    Unit{"n", Quantity::kForce, 1},
    Unit{"mn", Quantity::kForce, 1e-3},
    Unit{"un", Quantity::kForce, 1e-6},
    Unit{"kn", Quantity::kForce, 1e3},
    Unit{"lbf", Quantity::kForce, kPoundForce},
    Unit{"kgf", Quantity::kForce, kGravity},
    Unit{"kp", Quantity::kForce, kGravity},
    Unit{"gf", Quantity::kForce, 1e-3 * kGravity},
    Unit{"m", Quantity::kLength, 1},
    Unit{"cm", Quantity::kLength, 1e-2},
    Unit{"mm", Quantity::kLength, 1e-3},
    Unit{"um", Quantity::kLength, 1e-6},
    Unit{"nm", Quantity::kLength, 1e-9},
    Unit{"in", Quantity::kLength, kInch},
    Unit{"inch", Quantity::kLength, kInch},
    Unit{"thou", Quantity::kLength, 1e-3 * kInch},
    Unit{"mil", Quantity::kLength, 1e-3 * kInch},
    Unit{"s", Quantity::kTime, 1},
    Unit{"sec", Quantity::kTime, 1},
    Unit{"ms", Quantity::kTime, 1e-3},
    Unit{"us", Quantity::kTime, 1e-6},
    Unit{"ns", Quantity::kTime, 1e-9},
    Unit{"min", Quantity::kTime, 60},
    Unit{"h", Quantity::kTime, 3600},
    Unit{"%", Quantity::kNumber, 0.01},
    Unit{"percent", Quantity::kNumber, 0.01},
    Unit{"px", Quantity::kNumber, 1},
    Unit{"pixel", Quantity::kNumber, 1},
    Unit{"pixels", Quantity::kNumber, 1},
    Unit{"rad", Quantity::kNumber, 1},
    Unit{"-", Quantity::kNumber, 1},
    Unit{"1", Quantity::kNumber, 1},
    Unit{"mm/mm", Quantity::kNumber, 1},
    Unit{"m/m", Quantity::kNumber, 1},
    Unit{"in/in", Quantity::kNumber, 1},
};

// The micro sign and the Greek letter, in UTF-8 and in Latin-1, are written as u.
std::string WithPlainMicro(std::string_view text) {
  std::string plain(text);
  for (const std::string_view micro : {"\xC2\xB5", "\xCE\xBC", "\xB5"}) {
    for (std::size_t at; (at = plain.find(micro)) != std::string::npos;) {
      plain.replace(at, micro.size(), "u");
    }
  }
  return plain;
}

// Brackets hold units, but also words such as in `Strain (Extension) (%)`.
bool IsQualifier(std::string_view text) {
  constexpr std::array<std::string_view, 5> kShort{"true", "eng", "nom", "raw", "avg"};
  const bool letters = std::ranges::all_of(
      text, [](unsigned char c) { return std::isalpha(c) != 0 || c == ' ' || c >= 0x80; });
  return letters && (text.size() > 5 || std::ranges::count(kShort, Lowercase(text)) > 0);
}

void TakeUnit(const Unit& unit, ColumnTitle* column) {
  column->to_si = unit.to_si;
  column->quantity = unit.quantity;
  column->unknown_unit.clear();
}

// `Load (N)`, `Strain (Extension) (%)`, `Strain [-]`. Removes the brackets of units from the name.
void TakeBrackets(ColumnTitle* column) {
  std::size_t from = 0;
  for (;;) {
    const std::size_t open = column->name.find_first_of("([", from);
    if (open == std::string::npos) return;
    const std::size_t close =
        std::min(column->name.find_first_of(")]", open), column->name.size() - 1);
    const std::string inside(
        Trimmed(std::string_view(column->name).substr(open + 1, close - open - 1)));
    from = close + 1;
    if (const auto unit = FindUnit(inside)) {
      TakeUnit(*unit, column);
    } else if (IsQualifier(inside)) {
      continue;
    } else if (!column->to_si) {
      column->unknown_unit = inside;
    }
    column->name.erase(open, close - open + 1);
    from = open;
  }
}

// `Force / N`, `Stress, psi`, `P_MPa`, `Kraft in N`.
void TakeSuffix(ColumnTitle* column) {
  for (const std::string_view mark : {"/", ",", "_", " in "}) {
    const std::size_t at = column->name.rfind(mark);
    if (at == std::string::npos || at == 0) continue;
    const std::string suffix(Trimmed(std::string_view(column->name).substr(at + mark.size())));
    // In `stretch_1` the 1 is a number, not the unit.
    const auto unit = suffix == "1" ? std::nullopt : FindUnit(suffix);
    const bool needs_unit = mark == "/" || mark == ",";
    if (!unit && !needs_unit) continue;
    if (unit) {
      TakeUnit(*unit, column);
    } else {
      column->unknown_unit = suffix;
    }
    column->name.resize(at);
    return;
  }
}

}  // namespace

std::string InWords(Quantity quantity) {
  switch (quantity) {
    case Quantity::kNumber:
      return "a number without dimension (%, mm/mm or no unit)";
    case Quantity::kLength:
      return "a length in m cm mm um nm in";
    case Quantity::kForce:
      return "a force in N mN uN kN lbf kgf gf";
    case Quantity::kStress:
      return "a stress in Pa kPa MPa GPa N/mm2 N/cm2 bar psi ksi";
    case Quantity::kTime:
      return "a time in s ms us ns min h";
  }
  return {};
}

std::optional<Unit> FindUnit(std::string_view word) {
  word = Trimmed(word);
  if (word.size() > 2 && (word.front() == '(' || word.front() == '[') &&
      (word.back() == ')' || word.back() == ']')) {
    word = Trimmed(word.substr(1, word.size() - 2));
  }
  const std::string plain = WithPlainMicro(word);
  if (plain == "mPa") return Unit{"mPa", Quantity::kStress, 1e-3};
  if (plain == "MN") return Unit{"MN", Quantity::kForce, 1e6};
  const auto* found = std::ranges::find(kUnits, Lowercase(plain), &Unit::name);
  if (found == kUnits.end()) return std::nullopt;
  return *found;
}

ColumnTitle SplitTitle(std::string_view title) {
  ColumnTitle column{std::string(title)};
  TakeBrackets(&column);
  column.name = Trimmed(column.name);
  return column;
}

ColumnTitle SplitFreeTitle(std::string_view title) {
  ColumnTitle column = SplitTitle(title);
  if (!column.to_si && column.unknown_unit.empty()) TakeSuffix(&column);
  column.name = Lowercase(Trimmed(column.name));
  std::ranges::replace(column.name, '_', ' ');
  return column;
}

}  // namespace palpate
