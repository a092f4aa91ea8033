// A simulated contact of fingertips.
#include <memory>
#include <utility>

#include "slave/simulator/fingertips/tactile_site.h"
#include "tests/campaigns/robustness/stages.h"

namespace palpate::robustness {
namespace {

using Eigen::Vector3d;

class TouchStage final : public Stage {
 public:
  TouchStage(const std::string& name, Scene scene, const Counts& counts,
             const SiteResolution& resolution)
      : Stage(name, "fingertips", std::move(scene)) {
    script_ = counts.script();
    TactileSite site(this->scene(), resolution);
    const Vector3d home = site.home();
    const Vector3d way =
        (site.gap() + this->scene().operator_options.press_depth) * site.approach();
    std::vector<Shot> shots;
    for (std::size_t i = 0; i < script_.count; ++i) {
      site.MoveTool(home + counts.WayAt(i) * way);
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

constexpr SiteResolution kCoarse{.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8};

}  // namespace

std::unique_ptr<Stage> MakeTouchStage(Scene scene, const Counts& counts) {
  const std::string name = scene.name;
  return std::make_unique<TouchStage>(name, std::move(scene), counts, kCoarse);
}

std::unique_ptr<Stage> MakeTouchStage(const std::string& name, const std::string& scene,
                                      const Overrides& overrides, Extent extent) {
  const bool quick = extent == Extent::kQuick;
  const Counts counts = quick ? Counts{70, 45, 15, 45, 10} : Counts{70, 130, 60, 130, 30};
  return std::make_unique<TouchStage>(name, Shipped(scene, overrides), counts,
                                      quick ? kCoarse : SiteResolution{});
}

}  // namespace palpate::robustness
