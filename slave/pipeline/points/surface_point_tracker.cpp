#include "slave/pipeline/points/surface_point_tracker.h"

#include <algorithm>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "shared/mesh/solid_mesh.h"
#include "slave/mesh/files/mesh_file.h"
#include "slave/program/stopwatch.h"
#include "slave/vision/depth/depth_points.h"
#include "slave/vision/dots/dot_layout.h"
#include "slave/vision/dots/stereo_dots.h"
#include "slave/vision/stereo/pair_rig.h"
#include "slave/vision/texture/stereo_texture.h"

namespace palpate {
namespace {

const Eigen::Vector2d kUnseen = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());

// Base class of the two trackers that use a pair of cameras.
class PairPointTracker : public SurfacePointTracker {
 public:
  PairPointTracker(const Scene& scene, const StereoRig& rig)
      : SurfacePointTracker(scene, rig),
        rig_(rig),
        X_SL_(scene.sense.Find<StereoCameras>()->X_SL),
        X_LS_(X_SL_.inverse()) {}
  [[nodiscard]] std::optional<Eigen::Vector2d> Project(
      const Eigen::Vector3d& p_S) const noexcept override {
    return palpate::Project(rig_.left, X_LS_ * p_S);
  }

 protected:
  const StereoRig rig_;
  const Eigen::Isometry3d X_SL_;

 private:
  Eigen::Isometry3d X_LS_;
};

StereoDots::Params DotParams(const Scene& scene, const StereoRig& rig) {
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  StereoDots::Params params;
  params.rig = rig;
  params.X_SL = scene.sense.Find<StereoCameras>()->X_SL;
  params.X_SO = scene.object.X_SO;
  params.layout = DotPlaces(points);
  params.dot_radius = points.dot_radius;
  params.sigma_px = points.sigma;
  return params;
}

class DotPointTracker final : public PairPointTracker {
 public:
  DotPointTracker(const Scene& scene, const StereoRig& rig)
      : PairPointTracker(scene, rig), params_(DotParams(scene, rig)), dots_(params_) {
    const double distance = (X_SL_.inverse() * scene.object.X_SO).translation().norm();
    radius_px_ = rig.left.fx * params_.dot_radius / distance;
  }
  const SurfaceObservation& Process(const StereoPair& pair) noexcept override {
    return Checked(dots_.Observe(pair.left, pair.right), pair);
  }
  void Reset() override {
    dots_ = StereoDots(params_);
    SurfacePointTracker::Reset();
  }
  [[nodiscard]] bool at_rest_known() const override { return dots_.at_rest_known(); }
  [[nodiscard]] Eigen::Vector2d PlaceInImage(std::size_t i) const noexcept override {
    const auto& dots = dots_.left().dots();
    return i < dots.size() && dots[i].seen ? dots[i].dot.centre : kUnseen;
  }
  [[nodiscard]] double radius_px() const override { return radius_px_; }
  [[nodiscard]] int rest_images() const override { return params_.rest_images; }
  [[nodiscard]] std::string stage() const override { return "dots"; }

 private:
  StereoDots::Params params_;
  StereoDots dots_;
  double radius_px_ = 0;
};

class TexturePointTracker final : public PairPointTracker {
 public:
  TexturePointTracker(const Scene& scene, const StereoRig& rig)
      : PairPointTracker(scene, rig),
        options_(StereoTextureOptions::From(*scene.sense.Find<PointTracking>())),
        texture_(std::make_unique<StereoTexture>(rig_, X_SL_, options_)) {}
  const SurfaceObservation& Process(const StereoPair& pair) noexcept override {
    try {
      return Checked(texture_->Process(pair.left, pair.right), pair);
    } catch (const std::exception&) {  // the first images cannot be used
      return Checked({}, pair);
    }
  }
  void Reset() override {
    texture_ = std::make_unique<StereoTexture>(rig_, X_SL_, options_);
    SurfacePointTracker::Reset();
  }
  [[nodiscard]] bool at_rest_known() const override { return texture_->started(); }
  [[nodiscard]] Eigen::Vector2d PlaceInImage(std::size_t i) const noexcept override {
    const auto& windows = texture_->left_windows();
    return i < windows.size() && windows[i].seen ? windows[i].warp.p : kUnseen;
  }
  [[nodiscard]] double radius_px() const override { return 0.5 * options_.flow.window; }
  [[nodiscard]] int rest_images() const override { return 1; }
  [[nodiscard]] std::string stage() const override { return "texture"; }

 private:
  StereoTextureOptions options_;
  std::unique_ptr<StereoTexture> texture_;
};

DepthPoints::Params DepthParams(const Scene& scene) {
  DepthPoints::Params params;
  params.camera = *scene.sense.Find<DepthImages>();
  params.farthest = MaxDepth(scene);
  return params;
}

class DepthPointTracker final : public SurfacePointTracker {
 public:
  explicit DepthPointTracker(const Scene& scene)
      : SurfacePointTracker(scene, {}),
        params_(DepthParams(scene)),
        X_DS_(params_.camera.X_SD.inverse()),
        depths_(params_) {}
  const SurfaceObservation& Process(const StereoPair& pair) noexcept override {
    return Checked(depths_.Observe(pair.left), pair);
  }
  void Reset() override {
    depths_.Reset();
    SurfacePointTracker::Reset();
  }
  [[nodiscard]] bool at_rest_known() const override { return depths_.at_rest_known(); }
  [[nodiscard]] Eigen::Vector2d PlaceInImage(std::size_t i) const noexcept override {
    const bool seen = i < checked().points.size() && checked().points[i].seen;
    return seen ? depths_.place(i) : kUnseen;
  }
  [[nodiscard]] std::optional<Eigen::Vector2d> Project(
      const Eigen::Vector3d& p_S) const noexcept override {
    const Eigen::Vector3d p_D = X_DS_ * p_S;
    if (!(p_D.z() > 0)) return std::nullopt;
    const DepthImages& camera = params_.camera;
    return Eigen::Vector2d(camera.fx * p_D.x() / p_D.z() + camera.cx,
                           camera.fy * p_D.y() / p_D.z() + camera.cy);
  }
  [[nodiscard]] double radius_px() const override { return 0.5 * params_.cell; }
  [[nodiscard]] int rest_images() const override { return params_.rest_images; }
  [[nodiscard]] std::string stage() const override { return "depth"; }

 private:
  DepthPoints::Params params_;
  Eigen::Isometry3d X_DS_;
  DepthPoints depths_;
};

// Returns the surface in frame O of a box or mesh whose force is estimated.
SurfaceMesh ComparedSurface(const Scene& scene) {
  const Geometry& geometry = scene.object.geometry;
  if (!IsHeld(scene.object) || !scene.tool || !IsVolume(geometry)) return {};
  if (const auto* file = std::get_if<MeshFileGeometry>(&geometry)) {
    MeshFile mesh = ReadMeshFile(file->file, file->unit);
    if (auto* surface = std::get_if<SurfaceMesh>(&mesh.mesh)) return std::move(*surface);
    return SurfaceOf(std::get<SolidMesh>(mesh.mesh));
  }
  const auto* box = std::get_if<BoxGeometry>(&geometry);
  if (box == nullptr) return {};
  SurfaceMesh surface;
  for (int i = 0; i < 8; ++i) {
    surface.nodes.push_back(Eigen::Vector3d(i & 1, i >> 1 & 1, i >> 2 & 1).cwiseProduct(box->size));
  }
  for (const auto& [a, b, c, d] : {std::array{0, 2, 3, 1},
                                   {4, 5, 7, 6},
                                   {0, 1, 5, 4},
                                   {2, 6, 7, 3},
                                   {0, 4, 6, 2},
                                   {1, 3, 7, 5}}) {
    surface.triangles.push_back({a, b, c});
    surface.triangles.push_back({a, c, d});
  }
  return surface;
}

constexpr const char* kNoWindow =
    "no window of texture was found in both images: they may show too little texture, or a "
    "repeating one; left and right may be exchanged; the rig may be wrong; or the object may be "
    "too near";

std::string Size(const std::array<int, 2>& size) {
  return fmt::format("{} x {}", size[0], size[1]);
}

}  // namespace

SurfacePointTracker::SurfacePointTracker(const Scene& scene, const StereoRig& rig)
    : checks_(MakePointsChecks(scene, rig, ComparedSurface(scene), &rest_)) {}

void SurfacePointTracker::Reset() {
  checked_ = {};
  checks_.Reset();
}

const SurfaceObservation& SurfacePointTracker::Checked(const SurfaceObservation& seen,
                                                       const StereoPair& pair) {
  Stopwatch lap;
  checked_ = seen;
  checked_.sequence = pair.sequence;
  checked_.sensed_at = pair.sensed_at;
  checked_.skew = pair.skew;
  checked_.Add(checks_.Examine({pair.left, pair.right, checked_}).verdict);
  checks_us_ = lap.Lap();
  return checked_;
}

std::unique_ptr<SurfacePointTracker> MakeSurfacePointTracker(const Scene& scene,
                                                             const StereoRig& rig) {
  if (scene.sense.Find<DepthImages>()) return std::make_unique<DepthPointTracker>(scene);
  if (scene.sense.Find<PointTracking>()->track == PointTracking::Track::kTexture) {
    return std::make_unique<TexturePointTracker>(scene, rig);
  }
  return std::make_unique<DotPointTracker>(scene, rig);
}

std::string RestInWords(const SurfacePointTracker& tracker) {
  const int images = tracker.rest_images();
  return images == 1
             ? "the rest shape needs one image of the untouched object"
             : fmt::format("the rest shape needs {} images of the untouched object", images);
}

double MaxDepth(const Scene& scene) {
  const DepthImages& depth = *scene.sense.Find<DepthImages>();
  const double distance = (depth.X_SD.inverse() * scene.object.X_SO.translation()).norm();
  return std::max(DepthPoints::Params().farthest, 2 * distance);
}

std::string_view WhyFewWindows() {
  return std::string_view(kNoWindow).substr(std::string_view(kNoWindow).find("they may"));
}

std::string_view WhyNotFound(const Scene& scene) {
  if (scene.sense.Find<DepthImages>()) {
    return "the depth images show too little of a surface within range: check the images and their "
           "unit";
  }
  if (scene.sense.Find<PointTracking>()->track == PointTracking::Track::kTexture) {
    return kNoWindow;
  }
  return "no array of dots of this size was found in both images: check the sides (left, right), "
         "the rig and the layout";
}

StereoRig RigOf(const Scene& scene) {
  if (!scene.sense.Find<StereoCameras>()) return {};
  const std::filesystem::path& file = scene.sense.Find<StereoCameras>()->rig;
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(fmt::format("{}: {}", scene.file.string(), why));
  };
  if (file.empty()) {
    try {
      return SimulatedRig(scene);
    } catch (const std::invalid_argument& error) {
      refuse(error.what());
    }
  }
  StereoRig rig;
  try {
    rig = ReadRig(file);
  } catch (const std::runtime_error& error) {
    refuse(std::string("sense.camera.stereo.rig: ") + error.what());
  }
  if (!(rig.baseline() > 0)) {
    refuse("sense.camera.stereo.rig: " + file.string() +
           " is of one camera: expected the rig of a pair");
  }
  return rig;
}

void RequireRigFits(const Scene& scene, const StereoRig& rig, const StereoPair& pair) {
  if (!scene.sense.Find<StereoCameras>()) return;
  const auto require = [&](const char* side, const cv::Mat& image, const Lens& lens) {
    const std::array<int, 2> size{image.cols, image.rows};
    if (size == lens.size) return;
    throw std::runtime_error(
        fmt::format("{}: the {} images are {} px: expected {} px, the size in {}",
                    scene.file.string(), side, Size(size), Size(lens.size),
                    scene.sense.Find<StereoCameras>()->rig.empty()
                        ? "the rig"
                        : scene.sense.Find<StereoCameras>()->rig.string()));
  };
  require("left", pair.left, rig.left);
  require("right", pair.right, rig.right);
}

}  // namespace palpate
