// A press that one camera sees.
#include <utility>

#include <Eigen/Core>

#include "slave/simulator/camera/scripted_press.h"
#include "slave/simulator/camera/simulated_site.h"
#include "slave/vision/observation.h"
#include "tests/campaigns/cell/run.h"

namespace palpate::campaign {

using Eigen::Vector2d;
using Eigen::Vector3d;

// An object that moves under a tool at rest is equivalent to a tool that moves in the opposite
// direction. The simulated tool is moved this way.
Run RunOfCamera(const Scene& scene, const Counts& counts, const std::vector<Vector2d>& moves) {
  constexpr int kSteps = 8;  // steps of the tool between two images
  Run run{scene, {}, scene.sense.Find<Camera>()->pixel, {}};
  if (run.scene.site.embryo) {  // the campaigns test disturbed images, not punctures
    run.scene.site.embryo.reset();
    run.scene.operator_options.press_depth = 100e-6;
  }
  const PressMotion press = ScriptedPress(run.scene);
  const Camera& camera = *run.scene.sense.Find<Camera>();
  const CameraView view(camera, camera.size[0], camera.size[1]);
  const auto tip_at = [&](std::size_t index) -> Vector3d {
    const Vector3d home = press.Tip(0);
    return home + counts.WayAt(index) * (press.Tip(press.hold_begin()) - home);
  };
  const Vector2d& d = run.scene.tool->direction;
  const Vector2d shaft = -(view.ToImage({d.x(), d.y(), 0}) - view.ToImage({0, 0, 0})).normalized();
  SimulatedSite site(run.scene);
  Vector3d last = tip_at(0);
  for (std::size_t i = 0; i < counts.all(); ++i) {
    const Vector2d moved_I = moves.empty() ? Vector2d(0, 0) : moves.at(i);
    const Vector3d moved = view.ToSlave(moved_I) - view.ToSlave({0, 0});
    const Vector3d next = tip_at(i) - moved;
    for (int k = 1; k <= kSteps; ++k) site.MoveTool(last + (next - last) * k / kSteps);
    last = next;
    Shot shot{site.TakeImage(), {}, {}, site.truth(), {}};
    shot.truth.p_S_tip = tip_at(i);
    shot.views[0] = {view.ToImage(tip_at(i)), view.ToImage(tip_at(counts.rest + counts.in)), shaft,
                     run.scene.tool->width / camera.pixel};
    run.shots.push_back(std::move(shot));
  }
  return run;
}

}  // namespace palpate::campaign
