#include "shared/text/plausible.h"

#include <span>
#include <utility>

#include "shared/text/text.h"

namespace palpate {
namespace {

struct LikelyUnit {
  const char* name;
  double to_si;
};
constexpr LikelyUnit kStresses[] = {{"kPa", 1e3}, {"MPa", 1e6}, {"mPa", 1e-3}};
constexpr LikelyUnit kDensities[] = {{"g/cm3", 1e3}, {"t/mm3", 1e12}, {"g/m3", 1e-3}};
constexpr LikelyUnit kAccelerations[] = {{"mm/s2", 1e-3}, {"cm/s2", 1e-2}, {"g", 9.80665}};
constexpr LikelyUnit kLengths[] = {{"mm", 1e-3}, {"um", 1e-6}};
constexpr LikelyUnit kForces[] = {{"mN", 1e-3}, {"gf", 9.80665e-3}};

struct Range {
  double least, most;           // limits beyond which a remark is made
  double usual_min, usual_max;  // range that a suggested unit must produce
  const char* unit;
  std::span<const LikelyUnit> likely;
};

Range RangeOf(Plausible kind) {
  switch (kind) {
    case Plausible::kYoungModulus:  // from hydrogels to plastics
      return {50, 1e10, 1e2, 1e8, "Pa", kStresses};
    case Plausible::kDensity:  // from foams to metals
      return {5, 25e3, 20, 25e3, "kg/m3", kDensities};
    case Plausible::kGravity:  // from the moon to a centrifuge
      return {1.5, 30, 9, 10.5, "m/s2", kAccelerations};
    case Plausible::kBodySize:  // from a cell to a table
      return {20e-6, 2, 1e-3, 2, "m", kLengths};
    case Plausible::kFingertipForce:
      return {0, 200, 1e-3, 200, "N", kForces};
    case Plausible::kHandPosition:
      return {0, 2, 1e-3, 2, "m", kLengths};
  }
  return {};
}

}  // namespace

std::optional<std::string> ImplausibleRemark(std::string_view key, double value, Plausible kind) {
  const Range range = RangeOf(kind);
  if (value >= range.least && value <= range.most) return std::nullopt;
  std::string remark =
      std::string(key) + Formatted(" = %.4g %s: expected %g to %g %s", value, range.unit,
                                   range.least, range.most, range.unit);
  for (const auto& [name, to_si] : range.likely) {
    const double meant = to_si * value;
    if (meant < range.usual_min || meant > range.usual_max) continue;
    return remark + Formatted("; in %s it would be %.4g %s", name, meant, range.unit);
  }
  return remark;
}

}  // namespace palpate
