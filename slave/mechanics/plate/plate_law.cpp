#include "slave/mechanics/plate/plate_law.h"

#include <algorithm>
#include <cmath>

namespace palpate::plate {
namespace {

constexpr double kNearestRim = 1e-3;  // smallest distance from the rim that is used
constexpr double kShear = 7.2;

double Steep(double slenderness) {
  return 1.95 + 90 * slenderness;
}

double InsideRim(double place) {
  return std::max(kNearestRim, 1 - place * place);
}

}  // namespace

double ExcessAtDepth(const Indentation& indentation) noexcept {
  const double inside = InsideRim(indentation.place);
  const double steep = Steep(indentation.slenderness) * std::pow(indentation.deflection, 2);
  return kShear * std::pow(indentation.slenderness / inside, 2) + steep / std::pow(inside, 0.75);
}

double DeflectionOfExcess(double excess, double slenderness) noexcept {
  const double left = excess - kShear * std::pow(slenderness, 2);
  return std::sqrt(std::max(0.0, left) / Steep(slenderness));
}

double LawsSigma(const Indentation& indentation) noexcept {
  const double inside = InsideRim(indentation.place);
  const double shear = 2.5 * std::pow(indentation.slenderness, 2) / std::pow(inside, 3);
  const double steep = 1.25 * std::pow(indentation.deflection, 2) / inside;
  return std::hypot(shear, steep);
}

double ResolvedDeflection(double place) noexcept {
  return 6 * std::pow(InsideRim(place), 2);
}

}  // namespace palpate::plate
