#include "slave/commands/check/check_words.h"

#include <cmath>
#include <cstdio>
#include <variant>

#include <spdlog/fmt/fmt.h>

namespace palpate {

void PrintLine(const std::string& what, const std::string& text) {
  fmt::print("  {:<14} {}\n", what, text);
  std::fflush(stdout);  // what comes next may take a while
}

// Lengths with a readable unit.
std::string LengthInWords(double metres) {
  if (metres == 0) return "0";
  const double a = std::abs(metres);
  if (a >= 1e3) return fmt::format("{:.4g} km", metres * 1e-3);
  if (a >= 1) return fmt::format("{:.4g} m", metres);
  if (a >= 1e-3) return fmt::format("{:.4g} mm", metres * 1e3);
  if (a >= 1e-6) return fmt::format("{:.4g} um", metres * 1e6);
  return fmt::format("{:.4g} nm", metres * 1e9);
}

std::string InWords(const Geometry& geometry) {
  struct Visitor {
    std::string operator()(const RectangleGeometry& g) const {
      return fmt::format("rectangle {} x {}", LengthInWords(g.width), LengthInWords(g.height));
    }
    std::string operator()(const DiscGeometry& g) const {
      return fmt::format("disc of radius {}", LengthInWords(g.radius));
    }
    std::string operator()(const PolygonGeometry& g) const {
      return fmt::format("polygon with {} corners and {} holes", g.outline.outer.size(),
                         g.outline.holes.size());
    }
    std::string operator()(const ContourFileGeometry& g) const {
      return fmt::format("contour from {} ({} points)", g.file.string(), g.outline.outer.size());
    }
    std::string operator()(const ImageContourGeometry&) const {
      return "contour found in the first picture";
    }
    std::string operator()(const MembraneGeometry& g) const {
      return fmt::format("clamped membrane of radius {}", LengthInWords(g.radius));
    }
    std::string operator()(const BoxGeometry& g) const {
      return fmt::format("box {} x {} x {}, {} x {} x {} cells", LengthInWords(g.size.x()),
                         LengthInWords(g.size.y()), LengthInWords(g.size.z()), g.cells[0],
                         g.cells[1], g.cells[2]);
    }
    std::string operator()(const MeshFileGeometry& g) const { return "mesh " + g.file.string(); }
  };
  const double thickness = ThicknessOf(geometry);
  return std::visit(Visitor{}, geometry) +
         (thickness > 0 ? fmt::format(", {} thick", LengthInWords(thickness)) : "");
}

void PrintHand(const Scene& scene) {
  PrintLine("hand", fmt::format("position scale {:g}, force scale {:g}, at most {:g} N",
                                scene.operator_options.transform.position_scale,
                                scene.operator_options.transform.force_scale,
                                scene.operator_options.force_limit));
}

void PrintObject(const Scene& scene) {
  const Material& m = scene.object.material;
  fmt::print("{} ({})\n", scene.name, scene.file.string());
  PrintLine("object", InWords(scene.object.geometry));
  PrintLine("material", fmt::format("E = {:.4g} Pa, nu = {:g}{}", m.young_modulus, m.poisson_ratio,
                                    m.density > 0 ? fmt::format(", {:g} kg/m^3", m.density) : ""));
}

}  // namespace palpate
