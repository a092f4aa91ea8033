#include "slave/simulator/points/stereo_site.h"

#include <array>
#include <cstdint>
#include <mutex>
#include <stdexcept>
#include <variant>

#include <opencv2/core.hpp>
#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "slave/simulator/environment/painting.h"
#include "slave/simulator/points/painted_membrane.h"
#include "slave/simulator/points/scripted_membrane.h"
#include "slave/simulator/points/textured_target.h"
#include "slave/simulator/points/true_membrane.h"
#include "slave/vision/stereo/pair_rig.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// What stands before the cameras; eye 0 is the left one.
class Stage {
 public:
  virtual ~Stage() = default;
  Stage() = default;
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  // Like those of StereoSite.
  virtual void MoveTool(const Vector3d& p_S_tip, Patience patience) = 0;
  virtual void SolveEverywhere() = 0;
  [[nodiscard]] virtual Truth truth() const = 0;
  [[nodiscard]] virtual std::optional<TargetTruth> target() const = 0;
  [[nodiscard]] virtual Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const = 0;
  // The world as it will be painted from here on, `seconds` after the first pictures.
  virtual void Hold(double seconds) = 0;
  virtual const cv::Mat& Paint(std::size_t eye) = 0;
};

// `Painter`: DottedMembrane or TexturedMembrane.
template <typename Painter>
class MembraneStage final : public Stage {
 public:
  // `make` gives the painter of one eye, from its view.
  template <typename Make>
  MembraneStage(const Scene& scene, const site::MembraneResolution& resolution,
                const StereoRig& rig, const Make& make)
      : membrane_(scene, resolution),
        painters_{make(View(scene, rig.left, Isometry3d::Identity())),
                  make(View(scene, rig.right, rig.X_RL))} {}

  void MoveTool(const Vector3d& p_S_tip, Patience patience) override {
    membrane_.MoveTool(p_S_tip, patience);
  }
  void SolveEverywhere() override { membrane_.SolveEverywhere(); }
  [[nodiscard]] Truth truth() const override {
    const auto now = membrane_.now();
    const Vector3d f_O(0, 0, -site::ForceOf(now.dent));
    return {now.p_S_tip, now.in_contact, membrane_.X_SO().linear() * f_O, now.dent.depth,
            now.solved};
  }
  [[nodiscard]] std::optional<TargetTruth> target() const override { return std::nullopt; }
  [[nodiscard]] Vector3d TrueDisplacement(const Eigen::Vector2d& p_O) const override {
    return site::DisplacementOf(membrane_.now().dent, p_O);
  }
  void Hold(double) override { held_ = membrane_.now().dent; }
  const cv::Mat& Paint(std::size_t eye) override { return painters_[eye].Paint(held_); }

 private:
  [[nodiscard]] site::MembraneView View(const Scene& scene, const Lens& lens,
                                        const Isometry3d& X_CL) const {
    const auto& geometry = std::get<MembraneGeometry>(scene.object.geometry);
    const Isometry3d X_LO = scene.sense.Find<StereoCameras>()->X_SL.inverse() * membrane_.X_SO();
    return {lens, X_CL * X_LO, geometry.radius, geometry.thickness};
  }

  site::TrueMembrane membrane_;
  std::array<Painter, 2> painters_;
  site::Dent held_;
};

class TargetStage final : public Stage {
 public:
  static constexpr float kBeyond = 60;  // grey level

  TargetStage(const Scene& scene, const StereoRig& rig, const site::Exposure& exposure)
      : exposure_(exposure),
        target_(site::TexturedTarget::Shape{.seed = scene.site.seed + 7}),
        lenses_{rig.left, rig.right},
        X_CS_{scene.sense.Find<StereoCameras>()->X_SL.inverse(),
              rig.X_RL * scene.sense.Find<StereoCameras>()->X_SL.inverse()},
        X_SO_(TruePose(scene)),
        pace_(scene.site.pace) {
    truth_.p_S_tip = scene.manipulator.home;
    now_.X_SB_first = now_.X_SB = Pose(0);
  }

  void MoveTool(const Vector3d& p_S_tip, Patience) override {
    if (!p_S_tip.allFinite()) return;
    const std::lock_guard lock(mutex_);
    truth_.p_S_tip = p_S_tip;
  }
  void SolveEverywhere() override {}
  [[nodiscard]] Truth truth() const override {
    const std::lock_guard lock(mutex_);
    return truth_;
  }
  [[nodiscard]] Vector3d TrueDisplacement(const Eigen::Vector2d& /*p_O*/) const override {
    return Vector3d::Zero();
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
    return X_SO_ * Eigen::Translation3d(site::HeartPath(seconds, pace_));
  }

  const site::Exposure& exposure_;
  site::TexturedTarget target_;
  std::array<Lens, 2> lenses_;
  std::array<Isometry3d, 2> X_CS_;
  Isometry3d X_SO_;
  double pace_;
  cv::Mat seen_;  // CV_32F

  mutable std::mutex mutex_;  // guards what others read; written by TakePictures's thread only
  Truth truth_;
  TargetTruth now_;
};

std::unique_ptr<Stage> MakeStage(const Scene& scene, const site::MembraneResolution& resolution,
                                 const StereoRig& rig, const site::Exposure& exposure) {
  using Track = PointTracking::Track;
  const PointTracking& points = *scene.sense.Find<PointTracking>();
  const auto* geometry = std::get_if<MembraneGeometry>(&scene.object.geometry);
  if (points.track == Track::kSurface) {
    throw std::invalid_argument(
        "sense.points.track = surface: accepted by the simulator is dots or texture");
  }
  if (points.track == Track::kTexture && !geometry) {
    return std::make_unique<TargetStage>(scene, rig, exposure);
  }
  if (points.track == Track::kTexture) {
    return std::make_unique<MembraneStage<site::TexturedMembrane>>(
        scene, resolution, rig, [&](const site::MembraneView& view) {
          return site::TexturedMembrane(view, scene.site.seed, exposure);
        });
  }
  if (!geometry) {
    throw std::invalid_argument(
        "object.geometry: accepted by the simulator for sense.points.track = dots is a membrane");
  }
  const site::PrintedDots dots = site::DotsOn(*geometry, points);
  return std::make_unique<MembraneStage<site::DottedMembrane>>(
      scene, resolution, rig,
      [&](const site::MembraneView& view) { return site::DottedMembrane(view, dots, exposure); });
}

// The tip straight below home, as deep as the scene presses.
Vector3d DeepestOf(const Scene& scene) {
  const Vector3d n_S = scene.object.X_SO.linear().col(2);
  const double height = n_S.dot(scene.manipulator.home - scene.object.X_SO.translation());
  return scene.manipulator.home - (height + scene.operator_options.press_depth) * n_S;
}

}  // namespace

struct StereoSite::State {
  State(const Scene& scene, const site::MembraneResolution& resolution)
      : rig(SimulatedRig(scene)),
        exposure(scene.site, rig.left.size),
        stage(MakeStage(scene, resolution, rig, exposure)),
        rate(scene.sense.Find<StereoCameras>()->rate),
        press_depth(scene.operator_options.press_depth),
        p_S_home(scene.manipulator.home),
        p_S_deepest(DeepestOf(scene)) {
    if (!(rate > 0)) {
      throw std::invalid_argument("sense.camera.rate = " + std::to_string(rate) +
                                  " Hz: accepted is > 0");
    }
  }

  const StereoRig rig;
  site::Exposure exposure;  // TakePictures's thread only
  const std::unique_ptr<Stage> stage;
  const double rate;                     // [Hz]
  const double press_depth;              // of the scene's own press [m]
  const Vector3d p_S_home, p_S_deepest;  // of the tip in it [m]
  std::uint64_t pictures = 0;            // pairs taken; TakePictures's thread only
};

StereoSite::StereoSite(const Scene& scene, const site::MembraneResolution& resolution) try
    : state_(std::make_unique<State>(scene, resolution)) {
} catch (const std::invalid_argument& mistake) {
  if (scene.file.empty()) throw;
  throw std::invalid_argument(scene.file.string() + ": " + mistake.what());
}

StereoSite::~StereoSite() = default;

void StereoSite::MoveTool(const Vector3d& p_S_tip, Patience patience) {
  state_->stage->MoveTool(p_S_tip, patience);
}

void StereoSite::SolveAhead() {
  if (!target()) {
    spdlog::info("the simulator precomputes an indentation of {:.3g} mm",
                 1e3 * state_->press_depth);
    MoveTool(state_->p_S_deepest);
  }
  MoveTool(state_->p_S_home);
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

StereoPictures StereoSite::TakePictures() {
  State& state = *state_;
  state.exposure.Advance();
  state.stage->Hold(static_cast<double>(state.pictures++) / state.rate);
  StereoPictures pictures;
  pictures.left = state.exposure.Expose(state.stage->Paint(0));
  pictures.right = state.exposure.Expose(state.stage->Paint(1));
  return pictures;
}

std::unique_ptr<StereoSource> StereoSite::OpenPair(const Scene& scene, const Pace& pace) {
  if (!pace.is_live) {
    MembraneScript script;
    if (pace.duration > 0) script.target_seconds = pace.duration;
    return std::make_unique<ScriptedMembrane>(*this, scene, script);
  }
  return std::make_unique<LiveSource<StereoSource, StereoPair>>(
      state_->rate, 1, fmt::format("simulated stereo pair at {:g} Hz", state_->rate),
      [this, sequence = std::uint64_t{0}](Time now) mutable {
        auto [left, right] = TakePictures();
        StereoPair pair;
        pair.left = std::move(left);
        pair.right = std::move(right);
        pair.sensed_at = now;
        pair.sequence = ++sequence;
        return pair;
      });
}

const StereoRig& StereoSite::rig() const {
  return state_->rig;
}

}  // namespace palpate
