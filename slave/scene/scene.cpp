#include "slave/scene/scene.h"

#include <algorithm>
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

// Lists the files that are read beside the scene, for a geometry and for a sense and its parts.
struct ToInputs {
  std::vector<std::filesystem::path>* inputs;

  void Add(const std::filesystem::path& file) const {
    if (!file.empty()) inputs->push_back(file);
  }
  void AddImages(const std::filesystem::path& pattern) const {
    Add(pattern);
    if (pattern.has_filename()) Add(pattern.parent_path());
  }
  void operator()(const Camera& camera) const {
    if (camera.source != Camera::Source::kUrl) AddImages(camera.pattern);
    Add(camera.lens);
  }
  void operator()(const TipTracking& tip) const { Add(tip.template_file); }
  void operator()(const StereoCameras& pair) const {
    AddImages(pair.left), AddImages(pair.right);
    Add(pair.rig);
  }
  void operator()(const DepthImages& depth) const { AddImages(depth.pattern); }
  void operator()(const PointTracking& points) const { Add(points.layout); }
  void operator()(const Tactile& tactile) const {
    for (const auto& file : {tactile.file, tactile.network, tactile.electrodes}) {
      Add(file);
    }
    if (!tactile.network.empty()) Add(tactile.network / "network.json");
  }
  template <typename Other>
  void operator()(const Other& other) const {
    if constexpr (requires { other.file; }) Add(other.file);
  }
};

}  // namespace

bool IsPlanar(const Geometry& geometry) {
  return !IsVolume(geometry) && !IsSkin(geometry);
}

bool IsVolume(const Geometry& geometry) {
  return std::holds_alternative<BoxGeometry>(geometry) ||
         std::holds_alternative<MeshFileGeometry>(geometry);
}

bool IsSkin(const Geometry& geometry) {
  return std::holds_alternative<MembraneGeometry>(geometry) ||
         std::holds_alternative<DomeGeometry>(geometry);
}

bool IsHeld(const Object& object) {
  return !object.fixed.empty() || IsSkin(object.geometry);
}

bool Region::Contains(const Eigen::Vector3d& p_O) const {
  if (const auto* ball = std::get_if<Ball>(&where)) {
    return (p_O - ball->centre).norm() <= ball->radius;
  }
  return std::get<Eigen::AlignedBox3d>(where).contains(p_O);
}

Object Relaxed(Object object) {
  double left = 1;
  for (const RelaxationTerm& term : object.material.relaxation) left -= term.share;
  object.material.relaxation.clear();
  object.material.young_modulus *= left;
  for (Region& region : object.regions) region.young_modulus *= left;
  return object;
}

double RelativeModulus(const Object& object, const Eigen::Vector3d& p_O) {
  double modulus = object.material.young_modulus;
  for (const Region& region : object.regions) {
    if (region.Contains(p_O)) modulus = region.young_modulus;
  }
  return modulus / object.material.young_modulus;
}

void SenseOptions::Set(SenseChoice sense) {
  const auto old = std::ranges::find(senses_, sense.index(), &SenseChoice::index);
  if (old == senses_.end()) {
    senses_.push_back(std::move(sense));
  } else {
    *old = std::move(sense);
  }
}

bool HasStereoOrDepth(const SenseOptions& sense) {
  return sense.Find<PointsOptions>() != nullptr;
}

bool HasImages(const SenseOptions& sense) {
  return sense.Find<Camera>() != nullptr || HasStereoOrDepth(sense);
}

bool TakesImages(const SenseOptions& sense) {
  const auto is_stream = [](const auto* part) {
    return part != nullptr && part->source == std::remove_cvref_t<decltype(*part)>::Source::kStream;
  };
  return is_stream(sense.Find<Camera>()) || is_stream(sense.Find<StereoCameras>()) ||
         is_stream(sense.Find<DepthImages>());
}

bool IsSimulated(const Scene& scene) {
  const auto is_simulated = [](const auto* part) {
    return part != nullptr &&
           part->source == std::remove_cvref_t<decltype(*part)>::Source::kSimulated;
  };
  return is_simulated(scene.sense.Find<Camera>()) ||
         is_simulated(scene.sense.Find<StereoCameras>()) ||
         is_simulated(scene.sense.Find<Tactile>());
}

void StreamSimulated(Scene* scene) {
  bool connects = false;
  const auto stream = [&](auto* part) {
    if (part == nullptr) return;
    using Source = typename std::remove_cvref_t<decltype(*part)>::Source;
    if (part->source != Source::kSimulated) return;
    part->source = Source::kStream;
    connects = true;
  };
  stream(scene->sense.Find<Camera>());
  stream(scene->sense.Find<StereoCameras>());
  stream(scene->sense.Find<Tactile>());
  if (!connects) return;
  scene->is_simulated = scene->manipulator.source != ManipulatorOptions::Source::kStream;
  stream(&scene->manipulator);
  // The largest value of the key, because a late report of a simulated tool is harmless.
  scene->manipulator.silence = 0.1;
}

double SensorRate(const SenseOptions& sense) {
  double rate = 0;
  const auto take = [&](const auto& part) {
    if constexpr (requires { part.rate; }) rate = part.rate;
  };
  if (!sense.all().empty()) {
    std::visit([&](const auto& options) { ForEachPart(options, take); }, sense.all().front());
  }
  return rate;
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

bool MeetsObject(const Scene& scene) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  return tactile.source == Tactile::Source::kSimulated || tactile.has_recorded_poses ||
         std::ranges::any_of(tactile.fingers, &Finger::has_pose);
}

std::vector<std::filesystem::path> InputFilesOf(const Scene& scene) {
  std::vector<std::filesystem::path> inputs{scene.file};
  const ToInputs add{&inputs};
  std::visit(add, scene.object.geometry);
  for (const SenseChoice& sense : scene.sense.all()) {
    std::visit([&](const auto& options) { ForEachPart(options, add); }, sense);
  }
  return inputs;
}

}  // namespace palpate
