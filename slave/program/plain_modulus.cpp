#include "slave/program/plain_modulus.h"

#include <fmt/format.h>

namespace palpate {
namespace {

constexpr double kGravity = 9.81;  // [m/s^2]

struct Familiar {
  double below;  // Young's modulus [Pa]
  const char* thing;
};
// [paper: Young's moduli of tissues and elastomers in common tables; orders of magnitude]
constexpr Familiar kFamiliar[] = {
    {2e3, "jelly that hardly stands"},
    {1e4, "jelly, or the liver of an animal"},
    {4e4, "a marshmallow, or a relaxed muscle"},
    {2e5, "a gummy bear"},
    {1e6, "a soft eraser"},
    {5e6, "a rubber band"},
    {5e7, "the sole of a shoe"},
    {1e9, "a plastic bag"},
    {1e10, "a plastic ruler"},
};

}  // namespace

std::string StiffAs(double young_modulus) {
  for (const auto& [below, thing] : kFamiliar) {
    if (young_modulus < below) return thing;
  }
  return "stone or metal";
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
