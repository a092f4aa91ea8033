#include "slave/program/plain_modulus.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace palpate {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]

struct Known {
  double young_modulus;  // [Pa]
  const char* material;
};
// Sources: brain, Budday et al. 2015; liver, Roulot et al. 2008; breast, fat and gland, Krouskop
// et al. 1998; Shore 00, deploy/scenes/materials.md; Shore A, equation of Gent 1958; the rest,
// common tables of materials.
constexpr Known kKnown[] = {
    {1.4e3, "brain tissue"},
    {5.5e3, "healthy liver"},
    {23e3, "breast tissue"},
    {54e3, "silicone of Shore 00-10"},
    {97e3, "silicone of Shore 00-30"},
    {153e3, "silicone of Shore 00-50"},
    {0.41e6, "rubber of Shore A 10"},
    {1.15e6, "rubber of Shore A 30"},
    {2.47e6, "rubber of Shore A 50"},
    {5.5e6, "rubber of Shore A 70"},
    {21e6, "rubber of Shore A 90"},
    {0.2e9, "low-density polyethylene"},
    {3e9, "acrylic glass"},
    {17e9, "cortical bone"},
    {70e9, "glass"},
    {200e9, "steel"},
};

}  // namespace

std::string StiffAs(double young_modulus) {
  const auto off = [&](const Known& one) {
    return std::abs(std::log(young_modulus / one.young_modulus));
  };
  return std::min_element(
             std::begin(kKnown), std::end(kKnown),
             [&](const Known& one, const Known& other) { return off(one) < off(other); })
      ->material;
}

std::string ForceText(double newtons) {
  const double grams = 1e3 * newtons / kGravity;
  return fmt::format("{:.2g} N, the weight of {} g", newtons,
                     grams < 10 ? fmt::format("{:.2g}", grams) : fmt::format("{:.0f}", grams));
}

std::string ModulusText(double young_modulus) {
  constexpr double kEdge = 0.01, kPressed = 0.001;  // [m]
  return fmt::format(
      "about as stiff as {}; a cube of 10 mm, pressed by 1 mm between two plates, "
      "takes about {}",
      StiffAs(young_modulus), ForceText(young_modulus * kEdge * kEdge * kPressed / kEdge));
}

}  // namespace palpate
