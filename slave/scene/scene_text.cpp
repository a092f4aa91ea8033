#include "slave/scene/scene_text.h"

#include <algorithm>
#include <cmath>
#include <variant>

#include <fmt/format.h>

namespace palpate {

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
      return fmt::format("contour from {} ({} points)", g.file.filename().string(),
                         g.outline.outer.size());
    }
    std::string operator()(const ImageContourGeometry&) const {
      return "contour found in the first image";
    }
    std::string operator()(const MembraneGeometry& g) const {
      return fmt::format("clamped membrane of radius {}", LengthInWords(g.radius));
    }
    std::string operator()(const DomeGeometry& g) const {
      return fmt::format("air-filled membrane, {} high, of an ellipsoid with semi-axes {} {} {}",
                         LengthInWords(g.inflation), LengthInWords(g.semi_axes.x()),
                         LengthInWords(g.semi_axes.y()), LengthInWords(g.semi_axes.z()));
    }
    std::string operator()(const BoxGeometry& g) const {
      return fmt::format("box {} x {} x {}, {} x {} x {} cells", LengthInWords(g.size.x()),
                         LengthInWords(g.size.y()), LengthInWords(g.size.z()), g.cells[0],
                         g.cells[1], g.cells[2]);
    }
    std::string operator()(const MeshFileGeometry& g) const {
      return "mesh " + g.file.filename().string();
    }
  };
  const double thickness = ThicknessOf(geometry);
  return std::visit(Visitor{}, geometry) +
         (thickness > 0 ? fmt::format(", {} thick", LengthInWords(thickness)) : "");
}

std::string InWords(const Region& region) {
  const auto in_mm = [](const Eigen::Vector3d& p) {
    return fmt::format("[{:.4g}, {:.4g}, {:.4g}] mm", 1e3 * p.x(), 1e3 * p.y(), 1e3 * p.z());
  };
  const std::string modulus = fmt::format(": E = {:.4g} Pa", region.young_modulus);
  if (const auto* ball = std::get_if<Ball>(&region.where)) {
    return fmt::format("sphere of radius {} around {}", LengthInWords(ball->radius),
                       in_mm(ball->centre)) +
           modulus;
  }
  const auto& box = std::get<Eigen::AlignedBox3d>(region.where);
  constexpr double kUnbounded = 1e12;  // [m]
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d sizes = box.sizes();
    if (!(std::min(sizes[(axis + 1) % 3], sizes[(axis + 2) % 3]) > kUnbounded)) continue;
    return fmt::format("layer along {}, {} to {}", "xyz"[axis], LengthInWords(box.min()[axis]),
                       LengthInWords(box.max()[axis])) +
           modulus;
  }
  return "box from " + in_mm(box.min()) + " to " + in_mm(box.max()) + modulus;
}

}  // namespace palpate
