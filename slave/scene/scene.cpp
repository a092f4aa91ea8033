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

std::vector<std::filesystem::path> InputFilesOf(const Scene& scene) {
  std::vector<std::filesystem::path> inputs{scene.file};
  const auto add = [&](const std::filesystem::path& file) {
    if (!file.empty()) inputs.push_back(file);
  };
  const auto add_pictures = [&](const std::filesystem::path& pattern) {
    add(pattern);
    if (pattern.has_filename()) add(pattern.parent_path());
  };
  std::visit(
      [&](const auto& g) {
        if constexpr (requires { g.file; }) add(g.file);
      },
      scene.object.geometry);
  const SenseOptions& sense = scene.sense;
  if (sense.camera) add_pictures(sense.camera->pattern), add(sense.camera->lens);
  if (sense.tip) add(sense.tip->template_file);
  if (sense.stereo) {
    add_pictures(sense.stereo->left), add_pictures(sense.stereo->right);
    add(sense.stereo->rig);
  }
  if (sense.depth) add_pictures(sense.depth->pattern);
  if (sense.points) add(sense.points->layout);
  if (const auto& t = sense.tactile) {
    for (const auto& file : {t->file, t->poses, t->network, t->electrodes}) add(file);
    if (!t->network.empty()) add(t->network / "network.json");
    add(t->localise);
  }
  return inputs;
}

}  // namespace palpate
