// A simulated contact of fingertips.
#include <utility>

#include "slave/simulator/fingertips/tactile_site.h"
#include "tests/campaigns/cell/run.h"

namespace palpate::campaign {

using Eigen::Vector3d;

Run RunOfTouch(const Scene& scene, const Counts& counts, bool coarse) {
  constexpr SiteResolution kCoarse{.edge = 3.5e-3, .fine_reach = 4e-3, .growth = 0.8};
  Run run{scene, {}, 1, {}};
  TactileSite site(scene, coarse ? kCoarse : SiteResolution{});
  const Vector3d home = site.home();
  const Vector3d way = (site.gap() + scene.operator_options.press_depth) * site.approach();
  for (std::size_t i = 0; i < counts.all(); ++i) {
    site.MoveTool(home + counts.WayAt(i) * way);
    Shot shot;
    shot.touch = site.TakeSample({});
    shot.truth = site.truth();
    run.shots.push_back(std::move(shot));
  }
  return run;
}

}  // namespace palpate::campaign
