#include "slave/site/camera/simulated_site.h"

#include <optional>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>

#include "slave/site/camera/painter.h"
#include "slave/site/camera/patch_solution.h"
#include "slave/site/camera/scripted_press.h"
#include "slave/site/camera/true_body.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

using site::BoundaryPlace;

constexpr double kAhead = 0.1;     // solve when the tip is this near, in parts of the larger side
constexpr double kFarthest = 1e6;  // tips farther away are no tips, in parts of the larger side

const Scene& Checked(const Scene& scene) {
  if (!scene.tool || !(scene.tool->width > 0)) {
    throw std::invalid_argument(
        "tool.width: missing; accepted by the simulated site is the width of the contact, > 0");
  }
  if (!(scene.tool->direction.norm() > 0)) {
    throw std::invalid_argument("tool.direction = [0, 0]: accepted is a direction");
  }
  return scene;
}

}  // namespace

struct SimulatedSite::State {
  explicit State(const Scene& scene)
      : body(Checked(scene)),
        direction_O(body.X_SO().linear().transpose() * scene.tool->direction.normalized()),
        force_scale(scene.object.material.young_modulus * ThicknessOf(scene.object.geometry)),
        ahead(body, scene.object.material.poisson_ratio, scene.model.plane, scene.tool->width),
        painter(scene, body),
        straightening(StraighteningOf(*scene.sense.Find<Camera>())),
        p_S_tip(scene.manipulator.home) {
    pose.p_O_tip = ToBody(p_S_tip);
    if (!ahead.Await(ExpectedPlace(pose.p_O_tip, kFarthest * body.larger_side()))) {
      throw std::invalid_argument(
          "object.geometry: accepted by the simulated site is an outline that does not cross "
          "itself and can be filled with triangles");
    }
  }

  [[nodiscard]] Eigen::Vector2d ToBody(const Eigen::Vector3d& p_S) const {
    return body.X_SO().inverse() * Eigen::Vector2d(p_S.head<2>());
  }
  // Where the tool at `p_O` will touch within `reach` if it goes on the way it points; else the
  // nearest place.
  [[nodiscard]] BoundaryPlace ExpectedPlace(const Eigen::Vector2d& p_O, double reach) const {
    const auto ahead_of_tool = body.Entry(p_O, p_O + reach * direction_O);
    return ahead_of_tool ? *ahead_of_tool : body.Nearest(p_O);
  }
  void Move(const Eigen::Vector3d& p_S);

  const site::TrueBody body;
  const Eigen::Vector2d direction_O;  // along which the tool points
  const double force_scale;           // E t [N/m]
  site::SolutionsAhead ahead;
  site::Painter painter;              // TakePicture's thread only
  const PictureFilter straightening;  // as every source does it; empty: no lens

  std::mutex moving;                     // one mover at a time; guards `touched`
  std::optional<BoundaryPlace> touched;  // where the contact began

  std::mutex mutex;  // guards what others read
  Eigen::Vector3d p_S_tip;
  site::Pose pose;
  double depth = 0;
};

void SimulatedSite::State::Move(const Eigen::Vector3d& p_S) {
  const Eigen::Vector2d to = ToBody(p_S), from = pose.p_O_tip;
  site::Pose next{to, pose.contact, {0, 0}};
  if (touched && (to - touched->p_O).dot(touched->normal_O) > 0) touched.reset();
  if (!touched) {
    next.contact = nullptr;
    const auto entry = body.Entry(from, to);
    if (entry && body.Contains(to)) {
      next.contact = ahead.Await(*entry);
      if (next.contact) touched = entry;
    } else if (const auto near = body.Nearest(to);
               (near.p_O - to).norm() < kAhead * body.larger_side()) {
      ahead.Expect(ExpectedPlace(to, 2 * kAhead * body.larger_side()));
    }
  }
  if (touched) next.displacement_O = to - touched->p_O;
  const std::lock_guard lock(mutex);
  p_S_tip = p_S;
  pose = next;
  depth = touched ? -next.displacement_O.dot(touched->normal_O) : 0;
}

SimulatedSite::SimulatedSite(const Scene& scene) : state_(std::make_unique<State>(scene)) {}

SimulatedSite::~SimulatedSite() = default;

void SimulatedSite::MoveTool(const Eigen::Vector3d& p_S_tip, Patience /*patience*/) {
  if (!p_S_tip.allFinite()) return;
  if (p_S_tip.cwiseAbs().maxCoeff() > kFarthest * state_->body.larger_side()) return;
  const std::lock_guard moving(state_->moving);
  state_->Move(p_S_tip);
}

Truth SimulatedSite::truth() const {
  const std::lock_guard lock(state_->mutex);
  Truth truth{.p_S_tip = state_->p_S_tip, .depth = state_->depth};
  const site::Pose& pose = state_->pose;
  if (!pose.contact) return truth;
  truth.in_contact = true;
  const Eigen::Vector2d force_O =
      -state_->force_scale * (pose.contact->stiffness * pose.displacement_O);
  truth.force.head<2>() = state_->body.X_SO().linear() * force_O;
  return truth;
}

std::unique_ptr<FrameSource> SimulatedSite::OpenCamera(const Scene& scene, const Pace& pace) {
  if (!pace.is_live) return std::make_unique<ScriptedCamera>(*this, scene);
  const double rate = scene.sense.Find<Camera>()->rate;
  return std::make_unique<LiveSource<FrameSource, Frame>>(
      rate, 0, fmt::format("simulated site, camera at {:g} Hz", rate),
      [this, sequence = std::uint64_t{0}](Time now) mutable {
        return Frame{TakePicture(), ++sequence, now};
      });
}

cv::Mat SimulatedSite::TakePicture() {
  site::Pose pose;
  {
    const std::lock_guard lock(state_->mutex);
    pose = state_->pose;
  }
  const cv::Mat picture = state_->painter.Paint(pose);
  return state_->straightening ? state_->straightening(picture) : picture;
}

}  // namespace palpate
