#include "tests/adversity/stage.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>

#include <opencv2/core.hpp>

#include "slave/scene/scene_loader.h"
#include "slave/site/camera/scripted_press.h"
#include "slave/site/camera/simulated_site.h"
#include "slave/site/fingertips/tactile_site.h"
#include "slave/site/points/pair_rig.h"
#include "slave/site/points/stereo_site.h"
#include "slave/site/press_motion.h"
#include "slave/vision/observation.h"
#include "slave/vision/stereo/rig.h"
#include "tests/support/paths.h"

namespace palpate::adversity {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Overrides = std::vector<std::string>;

Scene Shipped(const std::string& name, const Overrides& overrides) {
  return LoadScene(SourcePath("/deploy/scenes/" + name + ".yaml"), overrides);
}

// How many samples each part of a press has.
struct Counts {
  std::size_t rest = 0, in = 0, hold = 0, back = 0, after = 0;
};
Script ScriptOf(const Counts& counts) {
  Script script;
  script.way = counts.rest;
  script.hold = script.way + counts.in;
  script.back = script.hold + counts.hold;
  script.count = script.back + counts.back + counts.after;
  return script;
}
// Part of the way in that is gone at this sample, 0 to 1.
double WayAt(const Script& script, const Counts& counts, std::size_t index) {
  if (index < script.way) return 0;
  if (index < script.hold) {
    return MinimumJerk(static_cast<double>(index - script.way + 1) /
                       static_cast<double>(counts.in));
  }
  if (index < script.back) return 1;
  const double back = static_cast<double>(index - script.back + 1);
  return MinimumJerk(std::max(0.0, 1 - back / static_cast<double>(counts.back)));
}

// --- one camera
class CameraStage final : public Stage {
 public:
  CameraStage(const std::string& name, Scene scene, const Counts& counts)
      : Stage(name, "camera", std::move(scene)),
        counts_(counts),
        press_(this->scene()),
        camera_(*this->scene().sense.Find<Camera>()),
        view_(camera_, camera_.size[0], camera_.size[1]) {
    script_ = ScriptOf(counts);
    Keep(Record({}));
  }

  std::vector<Shot> Moving(const std::function<Vector2d(const Moment&)>& moves) override {
    return Record(moves);
  }

  [[nodiscard]] View ViewOf(const Moment& moment) const override {
    View view;
    static_cast<Moment&>(view) = moment;
    view.tip_I = view_.ToImage(TipAt(moment.index));
    view.pressed_I = view_.ToImage(TipAt(script_.hold));
    const Vector2d& d = scene().tool->direction;
    view.shaft_I = -(view_.ToImage({d.x(), d.y(), 0}) - view_.ToImage({0, 0, 0})).normalized();
    view.width = scene().tool->width / camera_.pixel;
    return view;
  }
  [[nodiscard]] double pixel() const override { return camera_.pixel; }

 private:
  [[nodiscard]] Vector3d TipAt(std::size_t index) const {
    const Vector3d home = press_.Tip(0);
    return home + WayAt(script_, counts_, index) * (press_.Tip(press_.hold_begin()) - home);
  }

  // An object that moves under a tool that stands is, for the two of them, a tool that moves the
  // other way: the site is moved so, and its picture moved back.
  std::vector<Shot> Record(const std::function<Vector2d(const Moment&)>& moves) const {
    constexpr int kSteps = 8;  // between two pictures: the tool's way is followed, not jumped
    SimulatedSite site(scene());
    std::vector<Shot> shots;
    Vector3d last = TipAt(0);
    for (std::size_t i = 0; i < script_.count; ++i) {
      const Vector2d moved_I = moves ? moves({script_, i}) : Vector2d(0, 0);
      const Vector3d moved = view_.ToSlave(moved_I) - view_.ToSlave({0, 0});
      const Vector3d next = TipAt(i) - moved;
      for (int k = 1; k <= kSteps; ++k) site.MoveTool(last + (next - last) * k / kSteps);
      last = next;
      Shot shot{site.TakePicture(), {}, {}, site.truth()};
      shot.truth.p_S_tip = TipAt(i);
      if (moves) Bump(moved_I, When::kAlways)({}, shot.left);
      shots.push_back(std::move(shot));
    }
    return shots;
  }

  Counts counts_;
  ScriptedPress press_;
  const Camera& camera_;
  CameraView view_;
};

std::unique_ptr<Stage> MakeCamera(const std::string& name, Extent extent) {
  const Counts counts =
      extent == Extent::kQuick ? Counts{4, 24, 6, 10, 3} : Counts{6, 62, 20, 62, 10};
  return std::make_unique<CameraStage>(name, Shipped(name, {}), counts);
}

// --- two cameras
class PairStage final : public Stage {
 public:
  PairStage(const std::string& name, Scene scene, const Counts& counts)
      : Stage(name, "pairs", std::move(scene)), rig_(SimulatedRig(this->scene())) {
    script_ = ScriptOf(counts);
    const Eigen::Isometry3d X_SO = TruePose(this->scene());
    const Vector3d home = this->scene().manipulator.home;
    const Vector3d home_O = X_SO.inverse() * home;
    const double depth = this->scene().operator_options.press_depth;
    StereoSite site(this->scene());
    std::vector<Shot> shots;
    for (std::size_t i = 0; i < script_.count; ++i) {
      const double z = home_O.z() - WayAt(script_, counts, i) * (home_O.z() + depth);
      site.MoveTool(X_SO * Vector3d(home_O.x(), home_O.y(), z));
      StereoPictures pictures = site.TakePictures();
      shots.push_back({pictures.left, pictures.right, {}, site.truth()});
    }
    pressed_S_ = X_SO * Vector3d(home_O.x(), home_O.y(), 0);
    Keep(std::move(shots));
  }

  [[nodiscard]] View ViewOf(const Moment& moment) const override {
    View view;
    static_cast<Moment&>(view) = moment;
    const Eigen::Isometry3d& X_SL = scene().sense.Find<StereoCameras>()->X_SL;
    Vector3d p = X_SL.inverse() * pressed_S_;
    if (moment.side == 1) p = rig_.X_RL * p;
    const Lens& lens = moment.side == 0 ? rig_.left : rig_.right;
    view.tip_I = view.pressed_I = Project(lens, p).value_or(Vector2d(0, 0));
    view.width = scene().tool->width * lens.fx / p.z();
    return view;
  }
  [[nodiscard]] double pixel() const override { return 0.25 / rig_.left.fx; }

 private:
  StereoRig rig_;
  Vector3d pressed_S_{0, 0, 0};
};

std::unique_ptr<Stage> MakePair(const std::string& name, const Overrides& overrides,
                                Extent extent) {
  const Counts counts =
      extent == Extent::kQuick ? Counts{16, 8, 3, 4, 2} : Counts{20, 60, 15, 30, 10};
  return std::make_unique<PairStage>(name, Shipped("rubber-membrane", overrides), counts);
}

// --- fingertips
class TouchStage final : public Stage {
 public:
  TouchStage(const std::string& name, Scene scene, const Counts& counts,
             const SiteResolution& resolution)
      : Stage(name, "fingertips", std::move(scene)) {
    script_ = ScriptOf(counts);
    TactileSite site(this->scene(), resolution);
    const Vector3d home = site.home();
    const Vector3d way =
        (site.gap() + this->scene().operator_options.press_depth) * site.approach();
    std::vector<Shot> shots;
    for (std::size_t i = 0; i < script_.count; ++i) {
      site.MoveTool(home + WayAt(script_, counts, i) * way);
      Shot shot;
      shot.touch = site.TakeSample({});
      shot.truth = site.truth();
      shots.push_back(std::move(shot));
    }
    Keep(std::move(shots));
  }

  [[nodiscard]] View ViewOf(const Moment& moment) const override {
    View view;
    static_cast<Moment&>(view) = moment;
    return view;
  }
};

std::unique_ptr<Stage> MakeTouch(const std::string& name, const std::string& scene,
                                 const Overrides& overrides, Extent extent) {
  const bool quick = extent == Extent::kQuick;
  const Counts counts = quick ? Counts{70, 45, 15, 45, 10} : Counts{70, 130, 60, 130, 30};
  SiteResolution resolution;
  if (quick) resolution = {.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8};
  return std::make_unique<TouchStage>(name, Shipped(scene, overrides), counts, resolution);
}

StageMaker OneCamera(const std::string& name) {
  return {name, "camera", [name](Extent extent) { return MakeCamera(name, extent); }};
}
StageMaker Pair(const std::string& name, const Overrides& overrides) {
  return {name, "pairs", [=](Extent extent) { return MakePair(name, overrides, extent); }};
}
StageMaker Touch(const std::string& name, const std::string& scene, const Overrides& overrides) {
  return {name, "fingertips",
          [=](Extent extent) { return MakeTouch(name, scene, overrides, extent); }};
}

}  // namespace

Stage::Stage(std::string name, std::string sense, Scene scene)
    : name_(std::move(name)),
      sense_(std::move(sense)),
      scene_(std::move(scene)),
      rate_(SensorRate(scene_.sense)) {}

void Stage::Keep(std::vector<Shot> shots) {
  shots_ = std::move(shots);
  script_.touch = script_.hold;
  for (std::size_t i = 0; i < shots_.size(); ++i) {
    const Truth& truth = shots_[i].truth;
    if (truth.in_contact) script_.touch = std::min(script_.touch, i);
    peak_ = std::max(peak_, truth.force.norm());
    for (const FingerTruth& finger : truth.fingers) peak_ = std::max(peak_, finger.force.norm());
  }
}

std::vector<StageMaker> StagesOf(Extent extent) {
  std::vector<StageMaker> stages{OneCamera("silicone-block"), Pair("rubber-membrane", {}),
                                 Touch("foam-cube", "foam-cube", {})};
  stages.push_back(
      Touch("foam-cube-stiff", "foam-cube", {"object.material.young_modulus=100 kPa"}));
  stages.back().is_special = true;
  if (extent == Extent::kQuick) return stages;
  stages.push_back(OneCamera("zebrafish-embryo"));
  stages.push_back(Pair("rubber-membrane-texture", {"sense.points.track=texture"}));
  stages.push_back(Touch("foam-sponge", "foam-sponge", {}));
  stages.push_back(Touch("foam-bar", "foam-bar", {}));
  return stages;
}

}  // namespace palpate::adversity
