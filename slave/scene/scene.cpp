#include "slave/scene/scene.h"

#include <cmath>
#include <numbers>

namespace palpate {
namespace {

constexpr int kDiscCorners = 360;

struct ToOutline {
  Outline operator()(const RectangleGeometry& g) const {
    return {{{0, 0}, {g.width, 0}, {g.width, g.height}, {0, g.height}}, {}};
  }
  Outline operator()(const DiscGeometry& g) const {
    Outline outline;
    for (int i = 0; i < kDiscCorners; ++i) {
      const double angle = 2 * std::numbers::pi * i / kDiscCorners;
      outline.outer.emplace_back(g.radius * std::cos(angle), g.radius * std::sin(angle));
    }
    return outline;
  }
  Outline operator()(const PolygonGeometry& g) const { return g.outline; }
  Outline operator()(const ContourFileGeometry& g) const { return g.outline; }
  template <typename NotAnOutline>
  Outline operator()(const NotAnOutline&) const {
    return {};
  }
};

}  // namespace

bool IsPlanar(const Geometry& geometry) {
  return !IsVolume(geometry) && !std::holds_alternative<MembraneGeometry>(geometry);
}

bool IsVolume(const Geometry& geometry) {
  return std::holds_alternative<BoxGeometry>(geometry) ||
         std::holds_alternative<MeshFileGeometry>(geometry);
}

bool IsHeld(const Object& object) {
  return !object.fixed.empty() || std::holds_alternative<MembraneGeometry>(object.geometry);
}

bool HasEyes(const SenseOptions& sense) {
  return sense.stereo || sense.depth;
}

bool HasPictures(const SenseOptions& sense) {
  return sense.camera || HasEyes(sense);
}

double SensorRate(const SenseOptions& sense) {
  if (sense.camera) return sense.camera->rate;
  if (sense.stereo) return sense.stereo->rate;
  if (sense.depth) return sense.depth->rate;
  return sense.tactile ? sense.tactile->rate : 0;
}

double ThicknessOf(const Geometry& geometry) {
  return std::visit(
      [](const auto& g) {
        if constexpr (requires { g.thickness; }) return g.thickness;
        return 0.0;
      },
      geometry);
}

Outline OutlineOf(const Geometry& geometry) {
  return std::visit(ToOutline{}, geometry);
}

}  // namespace palpate
