#include "tests/campaigns/robustness/stage.h"

#include <algorithm>
#include <utility>

#include "slave/scene/scene_loader.h"
#include "slave/simulator/environment/press_motion.h"
#include "slave/simulator/environment/simulated_environment.h"
#include "tests/campaigns/robustness/stages.h"
#include "tests/support/paths.h"

namespace palpate::robustness {
namespace {

StageMaker OneCamera(const std::string& name) {
  return {name, "camera", [name](Extent extent) { return MakeCameraStage(name, extent); }};
}
StageMaker Pair(const std::string& name, const Overrides& overrides) {
  return {name, "pairs", [=](Extent extent) { return MakePairStage(name, overrides, extent); }};
}
StageMaker Depth(const std::string& name) {
  return {name, "pairs", [=](Extent extent) { return MakeDepthStage(name, extent); }, true};
}
StageMaker Touch(const std::string& name, const std::string& scene, const Overrides& overrides) {
  return {name, "fingertips",
          [=](Extent extent) { return MakeTouchStage(name, scene, overrides, extent); }};
}

}  // namespace

Scene Shipped(const std::string& name, const Overrides& overrides) {
  return LoadScene(SourcePath("/deploy/scenes/" + name + ".yaml"), overrides);
}

Script Counts::script() const {
  Script script;
  script.way = rest;
  script.hold = script.way + in;
  script.back = script.hold + hold;
  script.count = script.back + back + after;
  return script;
}

double Counts::WayAt(std::size_t index) const {
  const Script at = script();
  if (index < at.way) return 0;
  if (index < at.hold) {
    return MinimumJerk(static_cast<double>(index - at.way + 1) / static_cast<double>(in));
  }
  if (index < at.back) return 1;
  const auto gone = static_cast<double>(index - at.back + 1);
  return MinimumJerk(std::max(0.0, 1 - gone / static_cast<double>(back)));
}

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
                                 Depth("rubber-membrane-depth"),
                                 Touch("foam-cube", "foam-cube", {})};
  stages.push_back(
      Touch("foam-cube-stiff", "foam-cube", {"object.material.young_modulus=100 kPa"}));
  stages.back().is_special = true;
  if (extent == Extent::kQuick) return stages;
  stages.push_back(OneCamera("zebrafish-embryo"));
  stages.push_back(Pair("rubber-membrane-texture",
                        {"sense.points={track: texture, count: 31, sigma: 0.03 px}"}));
  stages.push_back(Touch("foam-sponge", "foam-sponge", {}));
  stages.push_back(Touch("foam-bar", "foam-bar", {}));
  return stages;
}

}  // namespace palpate::robustness
