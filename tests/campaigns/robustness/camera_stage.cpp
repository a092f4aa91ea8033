// A stage with a press that one camera sees.
#include <memory>
#include <utility>

#include <opencv2/core.hpp>

#include "slave/simulator/camera/scripted_press.h"
#include "slave/simulator/camera/simulated_site.h"
#include "slave/vision/observation.h"
#include "tests/campaigns/robustness/stages.h"

namespace palpate::robustness {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

class CameraStage final : public Stage {
 public:
  CameraStage(const std::string& name, Scene scene, const Counts& counts)
      : Stage(name, "camera", std::move(scene)),
        counts_(counts),
        press_(ScriptedPress(this->scene())),
        camera_(*this->scene().sense.Find<Camera>()),
        view_(camera_, camera_.size[0], camera_.size[1]) {
    script_ = counts.script();
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
    return home + counts_.WayAt(index) * (press_.Tip(press_.hold_begin()) - home);
  }

  // An object that moves under a tool at rest is equivalent to a tool that moves in the opposite
  // direction. The simulated tool is moved this way, and the image is then shifted back.
  std::vector<Shot> Record(const std::function<Vector2d(const Moment&)>& moves) const {
    constexpr int kSteps = 8;  // steps of the tool between two images
    SimulatedSite site(scene());
    std::vector<Shot> shots;
    Vector3d last = TipAt(0);
    for (std::size_t i = 0; i < script_.count; ++i) {
      const Vector2d moved_I = moves ? moves({script_, i}) : Vector2d(0, 0);
      const Vector3d moved = view_.ToSlave(moved_I) - view_.ToSlave({0, 0});
      const Vector3d next = TipAt(i) - moved;
      for (int k = 1; k <= kSteps; ++k) site.MoveTool(last + (next - last) * k / kSteps);
      last = next;
      Shot shot{site.TakeImage(), {}, {}, site.truth()};
      shot.truth.p_S_tip = TipAt(i);
      if (moves) Bump(moved_I, When::kAlways)({}, shot.left);
      shots.push_back(std::move(shot));
    }
    return shots;
  }

  Counts counts_;
  PressMotion press_;
  const Camera& camera_;
  CameraView view_;
};

}  // namespace

std::unique_ptr<Stage> MakeCameraStage(Scene scene, const Counts& counts) {
  const std::string name = scene.name;
  return std::make_unique<CameraStage>(name, std::move(scene), counts);
}

std::unique_ptr<Stage> MakeCameraStage(const std::string& name, Extent extent) {
  const Counts counts =
      extent == Extent::kQuick ? Counts{4, 24, 6, 10, 3} : Counts{6, 62, 20, 62, 10};
  Scene scene = Shipped(name, {});
  if (scene.site.embryo) {  // this campaign tests disturbed images, not punctures
    scene.site.embryo.reset();
    scene.operator_options.press_depth = 100e-6;
  }
  return std::make_unique<CameraStage>(name, std::move(scene), counts);
}

}  // namespace palpate::robustness
