#include "slave/simulator/fingertips/tactile_site.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <stdexcept>

#include <spdlog/fmt/fmt.h>
#include <spdlog/spdlog.h>

#include "slave/mesh/index.h"
#include "slave/simulator/fingertips/load_path.h"
#include "slave/simulator/fingertips/simulated_fingertip.h"
#include "slave/simulator/fingertips/true_object.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using simulation::LoadPathCache;

constexpr double kFriction = 1;       // of the skin on the object [-]
constexpr double kMaxDistance = 1e6;  // positions farther from home are ignored [m]
// Depth up to which presses are solved: at least kMinDepth [m], at least kDepthReserve times
// operator.press.depth, and at most kMaxOfBody of the body's size along the approach.
constexpr double kMinDepth = 0.01;
constexpr double kDepthReserve = 1.5;
constexpr double kMaxOfBody = 0.6;

// Position of the hand and its contacts.
struct HandState {
  Vector3d h_O{0, 0, 0};  // displacement from home
  double s = 0;           // component along the approach [m]
  bool pressing = false;
  Vector3d slip_O{0, 0, 0};       // tangential motion since the contact stuck [m]
  simulation::SolvedPress press;  // without depth steps while nothing touches
};

double DeepestOf(const Scene& scene, const simulation::TrueObject& object,
                 const simulation::RestBody& body) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector3d& p_O : body.surface.nodes) {
    const double along = p_O.dot(object.hand().approach_O);
    low = std::min(low, along);
    high = std::max(high, along);
  }
  const double wanted = std::max(kMinDepth, kDepthReserve * scene.operator_options.press_depth);
  return std::min(wanted, kMaxOfBody * (high - low));
}

constexpr int kStepsPerSample = 4;  // steps along a script's path from sample to sample
constexpr double kSettle = 0.2, kHold = 1, kRest = 0.5;  // of a script [s]

using FingertipSource = SimulatedSource<TactileSource, TactileFrame>;

}  // namespace

struct TactileSite::State {
  State(const Scene& scene, const SiteResolution& resolution)
      : object(scene, resolution),
        home_body(object.BodyFor(Vector3d::Zero())),
        period(1 / scene.sense.Find<Tactile>()->rate),
        press_depth(scene.operator_options.press_depth),
        skin_scale(simulation::kSkinRadius / scene.sense.Find<Tactile>()->finger_radius),
        tangential_part(2 * (1 - object.material().poisson_ratio) /
                        (2 - object.material().poisson_ratio)),
        all_series(object, DeepestOf(scene, object, *home_body)) {
    hand_now.press.body = home_body;
    for (std::size_t f = 0; f < object.hand().fingers.size(); ++f) {
      fingertips.emplace_back(scene.site.seed + static_cast<std::uint32_t>(f));
    }
    home_gap = all_series.Expect(all_series.KeyOf(Vector3d::Zero()));
  }

  [[nodiscard]] Isometry3d PoseOf(std::size_t f, const HandState& hand) const {
    return object.X_SO() * object.hand().PoseOf(f, hand.h_O);
  }
  [[nodiscard]] Vector3d home() const {
    return object.X_SO() * object.hand().fingers.front().X_OF_home *
           Vector3d(0, 0, -object.hand().shape.radius);
  }
  void Move(const Vector3d& h_O, WhenUnsolved when_unsolved);
  void Stick(HandState* hand);
  [[nodiscard]] Vector3d Sideways(std::size_t f, const HandState& hand,
                                  const simulation::TouchBetween& between) const;
  [[nodiscard]] FingerTruth TruthOf(std::size_t f, const HandState& hand) const;
  // Returns how the finger nearest to `p_O` moves with the hand: 1 in the same direction, -1
  // opposite, 0 not.
  [[nodiscard]] double SenseNear(const Vector3d& p_O, const HandState& hand) const;
  FingerReading ReadingOf(std::size_t f, const HandState& hand);
  [[nodiscard]] HandState now() const {
    const std::lock_guard lock(mutex);
    return hand_now;
  }

  const simulation::TrueObject object;
  const std::shared_ptr<const simulation::RestBody> home_body;
  // Period of the samples [s], operator.press.depth [m], radius of the simulated skin by that of
  // the scene's finger [-], tangential by normal stiffness of a contact (Mindlin) [-].
  const double period, press_depth, skin_scale, tangential_part;
  double home_gap = 0;  // way along the approach from home to the first contact [m]
  std::vector<SimulatedFingertip> fingertips;  // TakeSample's thread only
  std::uint64_t sequence = 0;                  // TakeSample's thread only

  std::mutex moving;                 // only one thread moves the tool; guards the members below
  LoadPathCache::Key pressed{0, 0};  // series of the present press
  Vector3d anchor_O{0, 0, 0};        // position across the approach at which it stuck

  mutable std::mutex mutex;  // guards the members that other threads read
  HandState hand_now;

  LoadPathCache all_series;
};

// Force of finger `f` on the object, across the approach [N].
Vector3d TactileSite::State::Sideways(std::size_t f, const HandState& hand,
                                      const simulation::TouchBetween& between) const {
  const double stiffness = tangential_part * std::max(between.slope, 0.0);
  const Vector3d force = object.hand().fingers[f].sense * stiffness * hand.slip_O;
  const double most = kFriction * between.touch.force_O.norm();
  return force.norm() > most ? Vector3d(most * force.normalized()) : force;
}

// The contact is dragged along where friction does not hold the first finger.
void TactileSite::State::Stick(HandState* hand) {
  const Vector3d lateral_O = hand->h_O - hand->s * object.hand().approach_O;
  const auto between = simulation::TouchAt(*hand->press.depth_steps, 0, hand->press.s);
  const double stiffness = tangential_part * between.slope;
  Vector3d slip_O = lateral_O - anchor_O;
  const double most = stiffness > 0 ? kFriction * between.touch.force_O.norm() / stiffness : 0;
  if (slip_O.norm() > most) slip_O *= most / slip_O.norm();
  anchor_O = lateral_O - slip_O;
  hand->slip_O = slip_O;
}

void TactileSite::State::Move(const Vector3d& h_O, WhenUnsolved when_unsolved) {
  HandState next;
  next.h_O = h_O;
  next.s = h_O.dot(object.hand().approach_O);
  next.press.body = now().press.body;
  const bool was_pressing = now().pressing;
  if (!was_pressing) pressed = all_series.KeyOf(h_O);
  const bool waits = when_unsolved == WhenUnsolved::kWait;
  if (next.s > (waits ? all_series.Expect(pressed) : all_series.ExpectNow(pressed))) {
    next.press = waits ? all_series.Await(pressed, next.s) : all_series.Find(pressed, next.s);
    next.pressing = true;
    if (!was_pressing) anchor_O = h_O - next.s * object.hand().approach_O;
    Stick(&next);
  }
  const std::lock_guard lock(mutex);
  hand_now = std::move(next);
}

FingerTruth TactileSite::State::TruthOf(std::size_t f, const HandState& hand) const {
  FingerTruth truth;
  truth.X_SF = PoseOf(f, hand);
  truth.p_S_contact = truth.X_SF * Vector3d(0, 0, -object.hand().shape.radius);
  const auto between =
      simulation::TouchAt(*hand.press.depth_steps, static_cast<int>(f), hand.press.s);
  if (!between.touch.touching) return truth;
  truth.in_contact = true;
  truth.p_S_contact = truth.X_SF * between.touch.p_F;
  truth.depth = between.touch.depth;
  const Vector3d force_O = between.touch.force_O + Sideways(f, hand, between);
  truth.force = -(object.X_SO().linear() * force_O);
  return truth;
}

double TactileSite::State::SenseNear(const Vector3d& p_O, const HandState& hand) const {
  double nearest = std::numeric_limits<double>::infinity(), sense = 0;
  for (std::size_t f = 0; f < object.hand().fingers.size(); ++f) {
    const double distance = (object.hand().PoseOf(f, hand.h_O).translation() - p_O).norm();
    if (distance >= nearest) continue;
    nearest = distance;
    sense = object.hand().fingers[f].sense;
  }
  return sense;
}

FingerReading TactileSite::State::ReadingOf(std::size_t f, const HandState& hand) {
  const FingerTruth truth = TruthOf(f, hand);
  const auto between =
      simulation::TouchAt(*hand.press.depth_steps, static_cast<int>(f), hand.press.s);
  FingertipLoad load;
  load.p_F = skin_scale * between.touch.p_F;
  load.f_F = truth.X_SF.linear().transpose() * truth.force;
  load.radius = skin_scale * between.touch.radius;
  FingerReading reading = fingertips[f].Sample(truth.in_contact ? &load : nullptr, period);
  reading.X_SF = truth.X_SF;
  return reading;
}

TactileSite::TactileSite(const Scene& scene, const SiteResolution& resolution)
    : state_(std::make_unique<State>(scene, resolution)) {}

TactileSite::~TactileSite() = default;

void TactileSite::MoveTool(const Vector3d& p_S_tip, WhenUnsolved when_unsolved) {
  if (!p_S_tip.allFinite()) return;
  const Vector3d h_O = state_->object.X_SO().linear().transpose() * (p_S_tip - state_->home());
  if (h_O.cwiseAbs().maxCoeff() > kMaxDistance) return;
  const std::lock_guard moving(state_->moving);
  state_->Move(h_O, when_unsolved);
}

void TactileSite::SolveAhead() {
  const double way = gap() + state_->press_depth;
  if (std::isfinite(way)) {
    spdlog::info("the simulator precomputes an indentation of {:.3g} mm",
                 1e3 * state_->press_depth);
    MoveTool(home() + way * approach());
  }
  MoveTool(home());
}

Truth TactileSite::truth() const {
  const HandState hand = state_->now();
  Truth truth;
  for (std::size_t f = 0; f < state_->fingertips.size(); ++f) {
    truth.fingers[f] = state_->TruthOf(f, hand);
  }
  const FingerTruth& first = truth.fingers.front();
  truth.p_S_tip = first.X_SF * Vector3d(0, 0, -state_->object.hand().shape.radius);
  truth.in_contact = first.in_contact;
  truth.force = first.force;
  truth.depth = first.depth;
  truth.solved = hand.press.solved;
  return truth;
}

std::unique_ptr<TactileSource> TactileSite::OpenFingertips(const Scene& scene,
                                                           const std::optional<ScriptedRun>& run) {
  if (run) return Play(*this, scene, ScriptedTouch(*this, scene, run->presses));
  const double rate = scene.sense.Find<Tactile>()->rate;
  return std::make_unique<FingertipSource>(rate,
                                           fmt::format("simulated fingertips at {:g} Hz", rate),
                                           [this] { return TakeSample(Clock::now()); });
}

Vector3d TactileSite::approach() const {
  return state_->object.X_SO().linear() * state_->object.hand().approach_O;
}

double TactileSite::gap() const {
  return state_->home_gap;
}

Vector3d TactileSite::home() const {
  return state_->home();
}

TactileFrame TactileSite::TakeSample(Time now) {
  const HandState hand = state_->now();
  TactileFrame frame;
  frame.sequence = ++state_->sequence;
  frame.sensed_at = now;
  for (std::size_t f = 0; f < state_->fingertips.size(); ++f) {
    frame.fingers[f] = state_->ReadingOf(f, hand);
  }
  return frame;
}

SurfaceMesh TactileSite::TrueSurface() const {
  const HandState hand = state_->now();
  const simulation::RestBody& body = *hand.press.body;
  std::vector<Vector3d> displacement_O(body.mesh.nodes.size(), Vector3d::Zero());
  simulation::DisplacementsAt(*hand.press.depth_steps, hand.press.s, &displacement_O);
  double largest = 0;
  for (const Vector3d& u : displacement_O) largest = std::max(largest, u.norm());
  SurfaceMesh deformed = body.surface;
  for (std::size_t i = 0; i < body.surface.nodes.size(); ++i) {
    Vector3d p_O = body.surface.nodes[i];
    if (largest > 0) {
      const Vector3d& u = displacement_O[Index(body.node_of[i])];
      // The indented surface moves sideways with its finger, in proportion to its depth.
      p_O += u + u.norm() / largest * state_->SenseNear(p_O, hand) * hand.slip_O;
    }
    deformed.nodes[i] = state_->object.X_SO() * p_O;
  }
  return deformed;
}

PressMotion ScriptedTouch(const TactileSite& site, const Scene& scene, int presses) {
  if (!std::isfinite(site.gap())) {
    throw std::invalid_argument(
        "sense.tactile: the fingertips do not meet the object on their path");
  }
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  const double way = site.gap() + scene.operator_options.press_depth;
  return {.home = site.home(),
          .way = way * site.approach(),
          .presses = std::max(presses, 1),
          .start = std::max(tactile.rest_samples, 0) / tactile.rate + kSettle,
          .ramp = kMinimumJerkPeak * std::abs(way) / PressSpeed(scene),
          .hold = kHold,
          .rest = kRest};
}

std::unique_ptr<TactileSource> Play(TactileSite& site, const Scene& scene,
                                    const PressMotion& motion) {
  const double rate = scene.sense.Find<Tactile>()->rate;
  const auto move = [&site, motion, rate](double t) {
    for (int step = kStepsPerSample - 1; step >= 0; --step) {
      site.MoveTool(motion.Tip(t - step / (kStepsPerSample * rate)));
    }
  };
  return std::make_unique<FingertipSource>(
      rate,
      fmt::format("simulated fingertips, {} scripted contact{}, {:g} Hz", motion.presses,
                  motion.presses == 1 ? "" : "s", rate),
      [&site] { return site.TakeSample({}); }, FingertipSource::Script{motion.duration(), move});
}

}  // namespace palpate
