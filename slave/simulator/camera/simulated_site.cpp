#include "slave/simulator/camera/simulated_site.h"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <utility>

#include <opencv2/imgproc.hpp>
#include <spdlog/fmt/fmt.h>

#include "slave/reference/planar/round_touch.h"
#include "slave/reference/planar/true_body.h"
#include "slave/simulator/camera/embryo.h"
#include "slave/simulator/camera/hand.h"
#include "slave/simulator/camera/painter.h"
#include "slave/simulator/camera/scripted_press.h"
#include "slave/simulator/camera/solutions_ahead.h"
#include "slave/vision/observation.h"
#include "slave/vision/stereo/lens_warp.h"

namespace palpate {
namespace {

using simulation::BoundaryPlace;

// Distance at which a solution is started in advance, relative to the larger side.
constexpr double kAhead = 0.1;
constexpr double kGoesAhead = 0.7;    // smallest cosine between motion and pointing direction
constexpr double kMaxDistance = 1e6;  // tips farther away are ignored; relative to the larger side
constexpr int kStepsPerImage = 16;    // steps of a scripted tool between two images
constexpr int kSteps = 100;        // steps of a search for the place where a round end will touch
constexpr double kTouches = 1e-6;  // distance at which the search ends, in radii

// See SiteOptions.
double LampLight(double span, Time now) {
  constexpr double kDim = 0.9;
  return span > 0 && std::fmod(SecondsBetween(Time{}, now) / span, 2) >= 1 ? kDim : 1;
}

cv::Mat Shifted(const cv::Mat& image, const Eigen::Vector2d& shift) {
  const cv::Matx23d warp(1, 0, shift.x(), 0, 1, shift.y());
  cv::Mat shifted;
  cv::warpAffine(image, shifted, warp, {}, cv::INTER_CUBIC, cv::BORDER_REPLICATE);
  return shifted;
}

// Returns the force of the tool on the body divided by E t [m].
Eigen::Vector2d ForceOf(const simulation::Pose& pose) {
  if (pose.contact->round) {
    return Touched(*pose.contact->round, pose.displacement_O, pose.turn).total();
  }
  return pose.contact->stiffness * pose.displacement_O;
}

}  // namespace

struct SimulatedSite::State {
  explicit State(const Scene& scene)
      : body(scene),
        direction_O(body.X_SO().linear().transpose() * scene.tool->direction.normalized()),
        force_scale(scene.object.material.young_modulus * ThicknessOf(scene.object.geometry)),
        tool(*scene.tool),
        radius(tool.shape == Tool::Shape::kRound ? tool.radius : 0),
        ahead(body, scene.object.material.poisson_ratio, scene.model.plane, tool,
              scene.site.hand.has_value(), ThicknessOf(scene.object.geometry)),
        painter(scene, body),
        view(*scene.sense.Find<Camera>(), scene.sense.Find<Camera>()->size[0],
             scene.sense.Find<Camera>()->size[1]),
        straightening(StraighteningOf(*scene.sense.Find<Camera>())),
        image_rate(scene.sense.Find<Camera>()->rate),
        motion(scene.site.motion),
        p_S_tip(scene.manipulator.home),
        p_S_imaged(p_S_tip) {
    if (scene.site.embryo) {
      embryo.emplace(*scene.site.embryo, scene.site.seed, 0.5 * body.larger_side(), direction_O);
    }
    if (scene.site.hand) hand.emplace(*scene.site.hand, scene.site.seed);
    pose.p_O_tip = ToBody(p_S_tip);
    if (tool.IsNarrowerThan(ThicknessOf(scene.object.geometry)) &&
        (tool.shape != Tool::Shape::kFlat || scene.site.hand || scene.site.embryo)) {
      throw std::invalid_argument(
          "tool: a simulated tool that reaches through a part of the thickness is flat, without "
          "site.hand and site.embryo");
    }
    if (!ahead.Await(ExpectedPlace(pose, kMaxDistance * body.larger_side(), direction_O))) {
      throw std::invalid_argument(
          "object.geometry: the simulator expects an outline that does not cross itself and "
          "can be filled with triangles; under a tool that reaches through a part of the thickness "
          "a rectangle whose sides are held whole");
    }
  }

  [[nodiscard]] double Now() const {
    return scripted_t ? *scripted_t : SecondsBetween(begin, Clock::now());
  }
  // Returns the position relative to the body at rest.
  [[nodiscard]] Eigen::Vector2d ToBody(const Eigen::Vector3d& p_S) const {
    return body.X_SO().inverse() * Eigen::Vector2d(p_S.head<2>());
  }
  // Returns the present displacement of the body, S [m].
  [[nodiscard]] Eigen::Vector3d Moved() const {
    if (motion.amplitude.isZero(0)) return Eigen::Vector3d::Zero();
    const double share = std::sin(2 * std::numbers::pi * Now() / motion.period);
    return {share * motion.amplitude.x(), share * motion.amplitude.y(), 0};
  }
  // Returns where the tool will touch within `reach` if it continues along the direction `way_O`;
  // else the nearest place.
  [[nodiscard]] BoundaryPlace ExpectedPlace(const simulation::Pose& tool_at, double reach,
                                            const Eigen::Vector2d& way_O) const;
  [[nodiscard]] Eigen::Vector2d DirectionOf(const simulation::Pose& tool_at) const {
    return Eigen::Rotation2Dd(tool_at.tilt) * direction_O;
  }
  // Returns the centre of a round end; the tip of a flat one.
  [[nodiscard]] Eigen::Vector2d CentreOf(const simulation::Pose& tool_at) const {
    return tool_at.p_O_tip - radius * DirectionOf(tool_at);
  }
  void Move(const Eigen::Vector3d& p_S);
  void Begin(const Eigen::Vector2d& from, simulation::Pose* next);
  [[nodiscard]] bool IsInside(const simulation::Pose& next) const;
  [[nodiscard]] bool HasLeft(const simulation::Pose& next) const;
  void Displace(simulation::Pose* next) const;
  [[nodiscard]] bool Breaks(double next_depth) const;
  // Ends the exposure and returns the pose to paint.
  simulation::Pose Expose();
  // Returns the shift of the whole image [px].
  Eigen::Vector2d ShiftInImage();

  const simulation::TrueBody body;
  const Eigen::Vector2d direction_O;  // along which the tool points
  const double force_scale;           // E t [N/m]
  const Tool tool;
  const double radius;  // of a round end; 0: flat [m]
  simulation::SolutionsAhead ahead;
  simulation::Painter painter;  // TakeImage's thread only
  const CameraView view;
  const ImageFilter straightening;  // the undistortion of every source; empty: no lens

  std::optional<simulation::Embryo> embryo;
  std::optional<simulation::Hand> hand;
  const double image_rate;  // [Hz]
  const SiteOptions::Motion motion;
  const Time begin = Clock::now();

  std::mutex moving;                     // only one thread moves the tool; guards the members below
  std::optional<double> scripted_t;      // [s]
  std::optional<BoundaryPlace> touched;  // place where the contact began
  double tilt_at_touch = 0;              // [rad]
  bool was_outside = false;              // whether the tool was outside the body since the start
  int insertion = 0;                     // number of the present or next insertion

  std::mutex mutex;  // guards the members that other threads read
  Eigen::Vector3d p_S_tip;
  simulation::Pose pose;
  double depth = 0;
  bool punctured = false;
  Eigen::Vector3d p_S_moved{0, 0, 0};  // of the body, with this pose
  Eigen::Vector3d p_S_imaged;          // tip in the last image
  Eigen::Vector2d velocity_S{0, 0};    // between the last two [m/s]
};

bool SimulatedSite::State::Breaks(double next_depth) const {
  return embryo && next_depth > embryo->PunctureDepth(insertion);
}

// A round end touches when the distance of its centre equals its radius. The search advances by
// steps that are certainly free of contact.
BoundaryPlace SimulatedSite::State::ExpectedPlace(const simulation::Pose& tool_at, double reach,
                                                  const Eigen::Vector2d& way_O) const {
  if (radius == 0) {
    const Eigen::Vector2d& p_O = tool_at.p_O_tip;
    const auto ahead_of_tool = body.Entry(p_O, p_O + reach * way_O);
    return ahead_of_tool ? *ahead_of_tool : body.Nearest(p_O);
  }
  const Eigen::Vector2d from = CentreOf(tool_at);
  double way = 0;
  for (int step = 0; step < kSteps && way < reach; ++step) {
    const Eigen::Vector2d centre = from + way * way_O;
    const BoundaryPlace near = body.Nearest(centre);
    const double gap = (near.p_O - centre).norm() - radius;
    if (gap < kTouches * radius || body.Contains(centre)) return near;
    way += gap;
  }
  return body.Nearest(from);
}

// Returns whether a part of the tool's end is inside of the body at rest.
bool SimulatedSite::State::IsInside(const simulation::Pose& next) const {
  const Eigen::Vector2d centre = CentreOf(next);
  if (body.Contains(centre)) return true;
  if (radius > 0) return (body.Nearest(centre).p_O - centre).norm() < radius;
  if (next.tilt == 0) return false;
  const Eigen::Vector2d d = DirectionOf(next), across(-d.y(), d.x());
  return body.Contains(centre + tool.width / 2 * across) ||
         body.Contains(centre - tool.width / 2 * across);
}

// The contact ends when the tool leaves the plane in which it began; a tilted flat face leaves with
// its last corner.
bool SimulatedSite::State::HasLeft(const simulation::Pose& next) const {
  const double height = (CentreOf(next) - touched->p_O).dot(touched->normal_O) - radius;
  return height > 0 && !(hand && radius == 0 && IsInside(next));
}

// Sets displacement and rotation of the contact, in the same convention as Touched.
void SimulatedSite::State::Displace(simulation::Pose* next) const {
  const Eigen::Vector2d& n = touched->normal_O;
  const Eigen::Vector2d along(-n.y(), n.x());
  next->turn = radius > 0 ? next->tilt - tilt_at_touch : next->tilt;
  next->displacement_O = CentreOf(*next) - touched->p_O - radius * n;
  next->displacement_O -= radius * std::sin(next->turn) * along;
}

// Called while out of contact, for a motion from `from`.
void SimulatedSite::State::Begin(const Eigen::Vector2d& from, simulation::Pose* next) {
  const Eigen::Vector2d& to = next->p_O_tip;
  next->contact = nullptr;
  const bool is_inside = IsInside(*next);
  was_outside |= !is_inside;
  std::optional<BoundaryPlace> entry;
  if (is_inside && (radius > 0 ? was_outside : hand.has_value())) {
    entry = body.Nearest(CentreOf(*next));
  } else if (radius == 0) {
    entry = body.Entry(from, to);
  }
  if (entry && is_inside) {
    next->contact = ahead.Await(*entry);
    if (next->contact) {
      touched = entry;
      tilt_at_touch = next->tilt;
    }
  } else if (const auto near = body.Nearest(to);
             (near.p_O - to).norm() < kAhead * body.larger_side()) {
    // Continues in the direction of motion, if the tool moves forward.
    const Eigen::Vector2d way = (to - from).stableNormalized();
    const bool goes_ahead = way.dot(direction_O) > kGoesAhead;
    ahead.Expect(
        ExpectedPlace(*next, 2 * kAhead * body.larger_side(), goes_ahead ? way : direction_O));
  }
}

void SimulatedSite::State::Move(const Eigen::Vector3d& p_S) {
  const Eigen::Vector3d moved = Moved();
  const Eigen::Vector2d to = ToBody(p_S - moved), from = pose.p_O_tip;
  simulation::Pose next{to, pose.contact, {0, 0}};
  next.t = Now();
  if (hand) next.tilt = hand->Tilt(next.t);
  bool through = punctured;
  if (touched && HasLeft(next)) {
    if (through) ++insertion;  // into another embryo
    through = false;
    touched.reset();
  }
  if (!touched) Begin(from, &next);
  if (touched) Displace(&next);
  double next_depth = touched ? std::max(0.0, -next.displacement_O.dot(touched->normal_O)) : 0;
  if (through || Breaks(next_depth)) {
    through = true;  // the membrane returns at once, with the tool inside
    next.contact = nullptr;
    next.displacement_O.setZero();
    next_depth = 0;
  }
  const std::lock_guard lock(mutex);
  p_S_tip = p_S;
  p_S_moved = moved;
  pose = next;
  depth = next_depth;
  punctured = through;
}

simulation::Pose SimulatedSite::State::Expose() {
  simulation::Pose seen;
  {
    const std::lock_guard lock(mutex);
    velocity_S = image_rate * (p_S_tip - p_S_imaged).head<2>();
    p_S_imaged = p_S_tip;
    seen = pose;
  }
  if (!seen.contact || !seen.contact->round) return seen;
  if (seen.displacement_O.isZero(0)) {
    seen.contact = nullptr;
  } else {
    seen.contact = std::make_shared<simulation::PatchSolution>(
        SecantAt(*seen.contact, seen.displacement_O, seen.turn));
  }
  return seen;
}

Eigen::Vector2d SimulatedSite::State::ShiftInImage() {
  const std::lock_guard lock(mutex);
  return view.ToImage(p_S_moved) - view.ToImage(Eigen::Vector3d::Zero());
}

SimulatedSite::SimulatedSite(const Scene& scene) : state_(std::make_unique<State>(scene)) {}

SimulatedSite::~SimulatedSite() = default;

void SimulatedSite::MoveTool(const Eigen::Vector3d& p_S_tip, WhenUnsolved /*when_unsolved*/) {
  if (!p_S_tip.allFinite()) return;
  if (p_S_tip.cwiseAbs().maxCoeff() > kMaxDistance * state_->body.larger_side()) return;
  const std::lock_guard moving(state_->moving);
  state_->Move(p_S_tip);
}

Truth SimulatedSite::truth() const {
  Truth truth;
  simulation::Pose pose;
  const auto& embryo = state_->embryo;
  {
    const std::lock_guard lock(state_->mutex);
    truth = {.p_S_tip = state_->p_S_tip, .depth = state_->depth, .punctured = state_->punctured};
    if (embryo) truth.force.head<2>() = embryo->Drag(state_->velocity_S);
    pose = state_->pose;
  }
  if (!pose.contact) return truth;
  truth.in_contact = true;
  const double scale = state_->force_scale * (embryo ? embryo->Stiffening(truth.depth) : 1);
  truth.force.head<2>() -= scale * (state_->body.X_SO().linear() * ForceOf(pose));
  return truth;
}

std::optional<Eigen::Vector3d> SimulatedSite::goal() const {
  if (!state_->embryo) return std::nullopt;
  const Eigen::Vector2d p_S = state_->body.X_SO() * state_->embryo->target_O();
  return Eigen::Vector3d(p_S.x(), p_S.y(), 0);
}

std::unique_ptr<FrameSource> SimulatedSite::OpenCamera(const Scene& scene,
                                                       const std::optional<ScriptedRun>& run) {
  using CameraSource = SimulatedSource<FrameSource, Frame>;
  const double rate = scene.sense.Find<Camera>()->rate;
  if (!run) {
    return std::make_unique<CameraSource>(rate, fmt::format("simulated camera at {:g} Hz", rate),
                                          [this, lamp = scene.site.lamp] {
                                            const double light = LampLight(lamp, Clock::now());
                                            cv::Mat image = TakeImage();
                                            if (light < 1) image *= light;
                                            return Frame{std::move(image)};
                                          });
  }
  const auto move = [this, motion = ScriptedPress(scene), rate](double t) {
    for (int step = kStepsPerImage - 1; step >= 0; --step) {
      const double at = std::max(0.0, t - step / (kStepsPerImage * rate));
      SetTime(state_->hand ? at : t);
      MoveTool(motion.Tip(at) + HandOffset(at));
    }
  };
  return std::make_unique<CameraSource>(
      rate, fmt::format("simulated camera, scripted contact, {:g} Hz", rate),
      [this] { return Frame{TakeImage()}; },
      CameraSource::Script{ScriptedPress(scene).duration(), move,
                           [this](double t) { return state_->hand ? state_->hand->Delay(t) : 0; }});
}

Eigen::Vector3d SimulatedSite::HandOffset(double t) const {
  return state_->hand ? state_->hand->Offset(t) : Eigen::Vector3d::Zero();
}

void SimulatedSite::SetTime(double t) {
  const std::lock_guard moving(state_->moving);
  state_->scripted_t = t;
}

cv::Mat SimulatedSite::TakeImage() {
  cv::Mat image = state_->painter.Paint(state_->Expose());
  if (!state_->motion.amplitude.isZero(0)) image = Shifted(image, state_->ShiftInImage());
  return state_->straightening ? state_->straightening(image) : image;
}

}  // namespace palpate
