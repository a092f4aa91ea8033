#include "slave/identify/magnitude.h"

#include <algorithm>
#include <cmath>

#include "shared/text/text.h"
#include "slave/identify/law_fit.h"

namespace palpate::identify {
namespace {

struct Magnitudes {
  double strain = 0, stretch = 1;  // largest
  double stress = 0;               // largest [Pa]
  double modulus = 0;              // Young's modulus of the whole curve [Pa]
  bool units_named = true;
};

void Require(bool possible, const std::string& name, const char* what, double value,
             const char* accepted) {
  if (possible) return;
  throw InputError(
      Formatted("%s: %s %.3g: expected %s. Check the units: those of the header, "
                "--stress-unit, --height, --diameter and --area",
                name.c_str(), what, value, accepted));
}

std::string Require(const std::string& name, const Magnitudes& m) {
  const bool soft = m.modulus >= kMinSoft && m.modulus <= kMaxSoft;
  Require(m.units_named || soft, name, "Young's modulus [Pa]", m.modulus,
          "1e3 to 1e8 for a column that names no unit; 10 to 1e12 for one that does");
  Require(m.modulus >= kMinModulus && m.modulus <= kMaxModulus, name, "Young's modulus [Pa]",
          m.modulus, "10 to 1e12");
  Require(m.modulus > kStiff || m.strain >= kMinStrain, name, "largest strain", m.strain,
          "0.01 or more of a solid softer than 1e9 Pa");
  Require(m.modulus <= kMaxSoft || m.strain <= kYieldStrain, name, "largest strain", m.strain,
          "at most 0.05 of a solid harder than 1e8 Pa, or --to 0.05");
  Require(m.modulus > kMaxSoft || m.stress <= kStrength, name, "largest stress [Pa]", m.stress,
          "at most 6e7, the strength of elastomers");
  std::string remark;
  if (m.modulus < kMinUsual || m.modulus > kMaxUsual) {
    remark =
        Formatted(": a modulus of %.3g Pa is rare for a soft solid: check the unit", m.modulus);
  } else if (m.stretch > kLongStretch) {
    remark = Formatted(": a stretch of %.3g is rare: check the unit", m.stretch);
  }
  return remark.empty() ? remark : name + remark;
}

}  // namespace

std::string RequirePossible(const MaterialTest& test) {
  const auto [low, high] = StretchRange({test});
  const LawFamily neo_hookean{.name = "neo-hookean", .fixed = {2}};
  return Require(test.name, {std::max(high - 1, 1 - low), high, test.Peak(),
                             FitLaw(neo_hookean, {test}).law.YoungModulus(), test.units_named});
}

std::string RequirePossible(const RelaxationTable& table) {
  Magnitudes m{.units_named = table.units_named};
  double both = 0, square = 0;
  for (std::size_t i = 0; i < table.time.size(); ++i) {
    m.strain = std::max(m.strain, std::abs(table.strain[i]));
    m.stress = std::max(m.stress, std::abs(table.stress[i]));
    both += table.strain[i] * table.stress[i], square += table.strain[i] * table.strain[i];
  }
  m.stretch = 1 + m.strain;
  m.modulus = (table.shear ? 3 : 1) * both / std::max(square, 1e-300);
  return Require(table.name, m);
}

}  // namespace palpate::identify
