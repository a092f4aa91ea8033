#include "slave/simulator/points/stereo_site.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include <opencv2/core.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "slave/simulator/environment/painting.h"
#include "slave/simulator/points/painted_membrane.h"
#include "slave/simulator/points/textured_target.h"
#include "slave/simulator/points/true_membrane.h"
#include "slave/vision/stereo/pair_rig.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// The scene before the cameras; camera 0 is the left one.
class Stage {
 public:
  virtual ~Stage() = default;
  Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  // See the methods of StereoSite.
  virtual void MoveTool(const Vector3d& p_S_tip, WhenUnsolved when_unsolved) = 0;
  virtual void SolveEverywhere() {}
  [[nodiscard]] virtual Truth truth() const = 0;
  [[nodiscard]] virtual std::optional<TargetTruth> target() const { return std::nullopt; }
  [[nodiscard]] virtual Vector3d TrueDisplacement(const Eigen::Vector2d& /*p_O*/) const {
    return Vector3d::Zero();
  }
  // Sets the state that is painted from now on, `seconds` after the first images.
  virtual void Hold(double seconds) = 0;
  virtual const cv::Mat& Paint(std::size_t eye) = 0;
};

// `Painter`: DottedMembrane or TexturedMembrane.
template <typename Painter>
class MembraneStage final : public Stage {
 public:
  // `make` returns the painter of one camera, from its view.
  template <typename Make>
  MembraneStage(const Scene& scene, const simulation::MembraneResolution& resolution,
                const StereoRig& rig, const Make& make)
      : membrane_(scene, resolution),
        painters_{make(View(scene, rig.left, Isometry3d::Identity())),
                  make(View(scene, rig.right, rig.X_RL))} {}

  void MoveTool(const Vector3d& p_S_tip, WhenUnsolved when_unsolved) override {
    membrane_.MoveTool(p_S_tip, when_unsolved);
  }
  void SolveEverywhere() override { membrane_.SolveEverywhere(); }
  [[nodiscard]] Truth truth() const override {
    const auto now = membrane_.now();
    const Vector3d f_O(0, 0, -simulation::ForceOf(now.indentation));
    return {now.p_S_tip, now.in_contact, membrane_.X_SO().linear() * f_O, now.indentation.depth,
            now.solved};
  }
  [[nodiscard]] Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const override {
    return simulation::DisplacementOf(membrane_.now().indentation, p_O);
  }
  void Hold(double) override { held_ = membrane_.now().indentation; }
  const cv::Mat& Paint(std::size_t eye) override { return painters_[eye].Paint(held_); }

 private:
  [[nodiscard]] simulation::MembraneView View(const Scene& scene, const Lens& lens,
                                              const Isometry3d& X_CL) const {
    const auto& geometry = std::get<MembraneGeometry>(scene.object.geometry);
    const Isometry3d X_LO = scene.sense.Find<StereoCameras>()->X_SL.inverse() * membrane_.X_SO();
    return {lens, X_CL * X_LO, geometry.radius, geometry.thickness};
  }

  simulation::TrueMembrane membrane_;
  std::array<Painter, 2> painters_;
  simulation::Indentation held_;
};

class TargetStage final : public Stage {
 public:
  static constexpr float kBeyond = 60;  // grey level

  TargetStage(const Scene& scene, const StereoRig& rig, const simulation::Exposure& exposure)
      : exposure_(exposure),
        target_(simulation::TexturedTarget::Shape{.seed = scene.site.seed + 7}),
        lenses_{rig.left, rig.right},
        X_CS_{scene.sense.Find<StereoCameras>()->X_SL.inverse(),
              rig.X_RL * scene.sense.Find<StereoCameras>()->X_SL.inverse()},
        X_SO_(TruePose(scene)),
        pace_(scene.site.pace) {
    truth_.p_S_tip = scene.manipulator.home;
    now_.X_SB_first = now_.X_SB = Pose(0);
  }

  void MoveTool(const Vector3d& p_S_tip, WhenUnsolved) override {
    if (!p_S_tip.allFinite()) return;
    const std::lock_guard lock(mutex_);
    truth_.p_S_tip = p_S_tip;
  }
  [[nodiscard]] Truth truth() const override {
    const std::lock_guard lock(mutex_);
    return truth_;
  }
  [[nodiscard]] std::optional<TargetTruth> target() const override {
    const std::lock_guard lock(mutex_);
    return now_;
  }
  void Hold(double seconds) override {
    const std::lock_guard lock(mutex_);
    now_.seconds = seconds;
    now_.X_SB = Pose(seconds);
  }
  const cv::Mat& Paint(std::size_t eye) override {
    const Lens& lens = lenses_[eye];
    seen_.create(lens.size[1], lens.size[0], CV_32F);
    seen_.setTo(kBeyond);
    target_.Draw(lens, X_CS_[eye] * now_.X_SB, seen_);
    exposure_.Blur(seen_);
    return seen_;
  }

 private:
  [[nodiscard]] Isometry3d Pose(double seconds) const {
    return X_SO_ * Eigen::Translation3d(simulation::HeartPath(seconds, pace_));
  }

  const simulation::Exposure& exposure_;
  simulation::TexturedTarget target_;
  std::array<Lens, 2> lenses_;
  std::array<Isometry3d, 2> X_CS_;
  Isometry3d X_SO_;
  double pace_;
  cv::Mat seen_;  // CV_32F

  // Guards the members that other threads read; only the thread of TakeImages writes them.
  mutable std::mutex mutex_;
  Truth truth_;
  TargetTruth now_;
};

std::unique_ptr<Stage> MakeStage(const Scene& scene,
                                 const simulation::MembraneResolution& resolution,
                                 const StereoRig& rig, const simulation::Exposure& exposure) {
  using Track = PointTracking::Track;
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  const auto* geometry = std::get_if<MembraneGeometry>(&scene.object.geometry);
  if (points.track == Track::kSurface) {
    throw std::invalid_argument(
        "sense.points.track = surface: the simulator expects dots or texture");
  }
  if (points.track == Track::kTexture && !geometry) {
    return std::make_unique<TargetStage>(scene, rig, exposure);
  }
  if (points.track == Track::kTexture) {
    return std::make_unique<MembraneStage<simulation::TexturedMembrane>>(
        scene, resolution, rig, [&](const simulation::MembraneView& view) {
          return simulation::TexturedMembrane(view, scene.site.seed, exposure);
        });
  }
  if (!geometry) {
    throw std::invalid_argument(
        "object.geometry: the simulator for sense.points.track = dots expects a membrane");
  }
  const simulation::PrintedDots dots = simulation::DotsOn(points);
  return std::make_unique<MembraneStage<simulation::DottedMembrane>>(
      scene, resolution, rig, [&](const simulation::MembraneView& view) {
        return simulation::DottedMembrane(view, dots, exposure);
      });
}

constexpr double kTargetSeconds = 10;  // of a textured target's path without a duration
constexpr int kRest = 15;              // pairs before the contact: the rest shape
constexpr int kDwell = 6;  // image pairs at each step during the approach; one during the retreat
constexpr double kStep = 0.5e-3;                           // [m]
constexpr double kFineBelow = 1e-3, kCoarseAbove = 50e-3;  // press depths with ten steps [m]

std::vector<double> StepsTo(double depth) {
  const double step = depth < kFineBelow || depth > kCoarseAbove ? depth / 10 : kStep;
  std::vector<double> depths{0};
  for (int k = 1; k * step < depth * (1 - 1e-9); ++k) depths.push_back(k * step);
  depths.push_back(depth);
  return depths;
}

// Returns the tip position straight below home, `depth` below the rest plane.
Vector3d TipAt(const Scene& scene, double depth) {
  const Isometry3d X_SO = TruePose(scene);
  const Vector3d p_O_home = X_SO.inverse() * scene.manipulator.home;
  return X_SO * Vector3d(p_O_home.x(), p_O_home.y(), -depth);
}

// Returns the tip position in each pair of a press without an operator. The tip waits at
// manipulator.home, moves straight down to the surface and in steps to operator.press.depth, then
// back in the same steps and home.
std::vector<Vector3d> ScriptedTips(const Scene& scene) {
  const std::vector<double> depths = StepsTo(scene.operator_options.press_depth);
  std::vector<Vector3d> tips(kRest, scene.manipulator.home);
  for (const double depth : depths) tips.insert(tips.end(), kDwell, TipAt(scene, depth));
  for (auto depth = depths.rbegin() + 1; depth != depths.rend(); ++depth) {
    tips.push_back(TipAt(scene, *depth));
  }
  tips.insert(tips.end(), kDwell, scene.manipulator.home);
  return tips;
}

}  // namespace

struct StereoSite::State {
  State(const Scene& true_scene, const simulation::MembraneResolution& resolution)
      : scene(true_scene),
        rig(SimulatedRig(scene)),
        exposure(scene.site, rig.left.size),
        stage(MakeStage(scene, resolution, rig, exposure)) {}

  const Scene scene;
  const StereoRig rig;
  simulation::Exposure exposure;  // TakeImages's thread only
  const std::unique_ptr<Stage> stage;
  std::uint64_t images = 0;  // pairs taken; TakeImages's thread only
};

StereoSite::StereoSite(const Scene& scene, const simulation::MembraneResolution& resolution) try
    : state_(std::make_unique<State>(scene, resolution)) {
} catch (const std::invalid_argument& mistake) {
  if (scene.file.empty()) throw;
  throw std::invalid_argument(scene.file.string() + ": " + mistake.what());
}

StereoSite::~StereoSite() = default;

void StereoSite::MoveTool(const Vector3d& p_S_tip, WhenUnsolved when_unsolved) {
  state_->stage->MoveTool(p_S_tip, when_unsolved);
}

void StereoSite::SolveAhead() {
  const Scene& scene = state_->scene;
  if (!target()) {
    const double depth = scene.operator_options.press_depth;
    spdlog::info("the simulator precomputes an indentation of {:.3g} mm", 1e3 * depth);
    MoveTool(TipAt(scene, depth));
  }
  MoveTool(scene.manipulator.home);
  state_->stage->SolveEverywhere();
}

Truth StereoSite::truth() const {
  return state_->stage->truth();
}

std::optional<TargetTruth> StereoSite::target() const {
  return state_->stage->target();
}

Vector3d StereoSite::TrueDisplacement(const Eigen::Vector2d& p_O) const {
  return state_->stage->TrueDisplacement(p_O);
}

StereoImages StereoSite::TakeImages() {
  State& state = *state_;
  state.exposure.Advance();
  state.stage->Hold(static_cast<double>(state.images++) /
                    state.scene.sense.Find<StereoCameras>()->rate);
  StereoImages images;
  images.left = state.exposure.Expose(state.stage->Paint(0));
  images.right = state.exposure.Expose(state.stage->Paint(1));
  return images;
}

std::unique_ptr<StereoSource> StereoSite::OpenPair(const Scene& scene,
                                                   const std::optional<ScriptedRun>& run) {
  using PairSource = SimulatedSource<StereoSource, StereoPair>;
  const double rate = scene.sense.Find<StereoCameras>()->rate;
  const auto take = [this] {
    auto [left, right] = TakeImages();
    return StereoPair{.left = std::move(left), .right = std::move(right)};
  };
  if (!run) {
    return std::make_unique<PairSource>(rate, fmt::format("simulated stereo pair at {:g} Hz", rate),
                                        take);
  }
  if (target()) {
    const double duration = run->duration > 0 ? run->duration : kTargetSeconds;
    return std::make_unique<PairSource>(
        rate, fmt::format("simulated stereo pair, textured target on its path, {:g} Hz", rate),
        take, PairSource::Script{duration - 0.5 / rate, [](double) {}});
  }
  const std::vector<Vector3d> tips = ScriptedTips(scene);
  const auto move = [this, tips, rate](double t) {
    MoveTool(tips[static_cast<std::size_t>(std::lround(rate * t))]);
  };
  return std::make_unique<PairSource>(
      rate, fmt::format("simulated stereo pair, scripted contact, {:g} Hz", rate), take,
      PairSource::Script{(static_cast<double>(tips.size()) - 0.5) / rate, move});
}

const StereoRig& StereoSite::rig() const {
  return state_->rig;
}

}  // namespace palpate
