#include "slave/pipeline/fingertips/tactile_estimator.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "slave/capture/tactile_recording.h"
#include "slave/pipeline/base/sensing_pipeline.h"

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr double kSameRate = 0.01;  // relative
constexpr double kSilence = 100;    // periods: more is no other gap
// Felt over modelled force, by how far the press goes in parts of the scene's.
constexpr double kDeep = 0.6, kLeastDeep = 0.65, kMostDeep = 1.5;
constexpr double kLeastShallow = 0.35, kMostShallow = 1.8;
constexpr double kClear = 5e-3;     // between skin and object [m]
constexpr double kArmApart = 5e-4;  // how far arm and fingertip may part [m]
constexpr int kArmForgives = 15;    // samples: a network looks back as far

bool SharesNode(const TactileBody& body, const Contact& a, const Contact& b) {
  const auto& one = body.surface.triangles[static_cast<std::size_t>(a.element)];
  const auto& other = body.surface.triangles[static_cast<std::size_t>(b.element)];
  return std::ranges::any_of(one, [&](int i) { return std::ranges::count(other, i) > 0; });
}

Isometry3d Carried(const Finger& finger, const Vector3d& way) {
  Isometry3d X_SF = finger.X_SF;
  if (finger.motion == Finger::Motion::kHand) X_SF.translation() += way;
  if (finger.motion == Finger::Motion::kOpposite) X_SF.translation() -= way;
  return X_SF;
}

// What a recording does not have reads 0, at rest and in contact: to a network that takes it that
// is a wrong number, and nobody would notice. Throws std::runtime_error naming the column.
void RequireSignals(const Tactile& tactile, const ForceNetwork& network) {
  const bool takes_all = network.info().inputs > kElectrodeCount;
  if (tactile.source != Tactile::Source::kRecording || !takes_all) return;
  std::vector<std::string> wanted;
  for (const Finger& finger : tactile.fingers) wanted.push_back(finger.name);
  for (const RecordedFinger& finger : ReadTactileFingers(tactile.file, wanted)) {
    const std::string missing = finger.MissingColumn();
    if (missing.empty()) continue;
    throw std::runtime_error(
        fmt::format("{}: no column {}: {} needs E1 to E19, pac0 and pdc (accepted without them: a "
                    "network that uses only the electrodes)",
                    tactile.file.string(), missing, tactile.network.string()));
  }
}

// A file that a scene names and that cannot be used makes the scene unusable.
template <typename Load>
auto NamingTheKey(const Scene& scene, const char* key, const Load& load) {
  try {
    return load();
  } catch (const std::runtime_error& e) {
    throw std::invalid_argument(
        fmt::format("{}: sense.tactile.{}: {}", scene.file.string(), key, e.what()));
  }
}

}  // namespace

TactileSenses LoadSenses(const Scene& scene) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  TactileSenses senses;
  if (!tactile.network.empty()) {
    senses.network =
        NamingTheKey(scene, "network", [&] { return LoadForceNetwork(tactile.network); });
    const double rate = senses.network->info().rate;
    if (std::abs(rate - tactile.rate) > kSameRate * rate) {
      throw std::invalid_argument(
          fmt::format("{}: sense.tactile.rate = {:g} Hz: accepted is {:g} Hz, for which {} was "
                      "trained",
                      scene.file.string(), tactile.rate, rate, tactile.network.string()));
    }
    if (tactile.carries_state && !senses.network->HasState()) {
      throw std::invalid_argument(
          fmt::format("{}: sense.tactile.state = carried: accepted is windowed for {}, which has "
                      "no state",
                      scene.file.string(), tactile.network.string()));
    }
    RequireSignals(tactile, *senses.network);
  }
  const ElectrodeLayout layout = NamingTheKey(scene, "electrodes", [&] {
    return tactile.electrodes.empty() ? SimulatedLayout(tactile.finger_radius)
                                      : ReadElectrodeLayout(tactile.electrodes);
  });
  senses.localiser =
      NamingTheKey(scene, "localise", [&] { return MakeLocaliser(tactile, layout); });
  return senses;
}

TactileEstimator::TactileEstimator(const Scene& scene)
    : TactileEstimator(scene, LoadSenses(scene)) {}

TactileEstimator::TactileEstimator(const Scene& scene, TactileSenses senses)
    : scene_fingers_(scene.sense.Find<Tactile>()->fingers),
      has_poses_file_(!scene.sense.Find<Tactile>()->poses.empty()),
      X_SO_(scene.object.X_SO),
      p_S_home_(scene.manipulator.home),
      press_depth_(scene.operator_options.press_depth),
      pose_tolerance_(scene.sense.Find<Tactile>()->pose_tolerance),
      period_(1 / scene.sense.Find<Tactile>()->rate),
      radius_(scene.sense.Find<Tactile>()->finger_radius),
      senses_(std::move(senses)) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  for (std::size_t i = 0; i < scene_fingers_.size(); ++i) {
    fingertips_.emplace_back(tactile, senses_.network.get(), *senses_.localiser);
    finger_contacts_.emplace_back(tactile);
  }
  contacts_.reserve(scene_fingers_.size());
  acting_.reserve(scene_fingers_.size());
  if (scene_fingers_.size() > 1) felt_.finger_count = finger_count();
  Adopt(Prepare(scene), scene);
}

TactileEstimator::~TactileEstimator() = default;

std::unique_ptr<TactileBody> TactileEstimator::Prepare(const Scene& scene, Progress* progress) {
  return MeetsObject(scene) ? MakeTactileBody(scene, progress) : nullptr;
}

void TactileEstimator::Adopt(std::unique_ptr<TactileBody> body, const Scene& scene) {
  body_ = std::move(body);
  local_touch_.emplace(scene);
  LetGo();
}

void TactileEstimator::LetGo() noexcept {
  for (FingerContact& contact : finger_contacts_) contact.LetGo();
  contacts_.clear();
  solution_ = {};
  acting_.clear();
  at_rest_ = true;
  last_shape_ = {};
}

void TactileEstimator::Reset() noexcept {
  for (Fingertip& fingertip : fingertips_) fingertip.Reset();
  LetGo();
  local_touch_->Forget();
  arm_.Reset();
  arm_doubts_ = 0;
  if (body_) body_->deformation->Reset();
}

const ContactEstimate& TactileEstimator::Estimate(const TactileFrame& frame,
                                                  const Vector3d& p_S_tip,
                                                  const std::optional<double>& arm_lag) noexcept {
  Stopwatch total, lap;
  const int missing = MissingBefore(frame);
  for (std::size_t i = 0; i < fingertips_.size(); ++i) {
    for (int k = 0; k < missing; ++k) fingertips_[i].Estimate(FingerReading{}, false);
    Place(i, frame.fingers[i], p_S_tip);
    fingertips_[i].Estimate(frame.fingers[i], frame.after_gap && missing == 0, IsClear(i));
  }
  times_.tactile.Add(lap.Lap());
  felt_.processed_at = Clock::now();
  double checks_us = 0;
  for (const Fingertip& fingertip : fingertips_) checks_us += fingertip.checks_us();
  times_.checks.Add(checks_us);
  for (std::size_t i = 0; i < fingertips_.size(); ++i) UpdateContact(i);
  times_.contact.Add(lap.Lap());
  if (body_) Deform();
  // Samples that touch nothing would hide how long those take that do.
  const double mechanics = lap.Lap();
  if (!contacts_.empty()) times_.mechanics.Add(mechanics);
  for (std::size_t i = 0; i < fingertips_.size(); ++i) ReportFinger(i);
  ReportTool(frame, p_S_tip);
  if (arm_lag && frame.fingers.front().X_SF) CompareWithEncoders({p_S_tip, *arm_lag});
  times_.total.Add(total.Lap());
  return felt_;
}

// Samples that did not come since the last one, as the stamps say, as many as make a silence; 0
// where it is unknown how many.
int TactileEstimator::MissingBefore(const TactileFrame& frame) const noexcept {
  const double periods = SecondsBetween(felt_.sensed_at, frame.sensed_at) / period_;
  if (felt_.sample == 0 || !(periods > 1.5)) return 0;
  return static_cast<int>(std::min(std::round(periods), kSilence)) - 1;
}

void TactileEstimator::Place(std::size_t i, const FingerReading& reading,
                             const Vector3d& p_S_tip) noexcept {
  FingerEstimate& finger = fingers_[i];
  finger.has_pose = reading.X_SF.has_value() || (scene_fingers_[i].has_pose && !has_poses_file_);
  if (reading.X_SF) {
    finger.X_SF = *reading.X_SF;
  } else if (finger.has_pose && p_S_tip.allFinite()) {
    finger.X_SF = Carried(scene_fingers_[i], p_S_tip - p_S_home_);
  }
  if (!finger.X_SF.matrix().allFinite()) {
    finger.has_pose = false;
    finger.X_SF = Isometry3d::Identity();
  }
  finger.p_S_apex = finger.X_SF * Vector3d(0, 0, -radius_);
}

// Whether the fingertip is so far from the object that a pose as wrong as poses are still has it
// touch nothing.
bool TactileEstimator::IsClear(std::size_t i) const noexcept {
  if (!body_ || !fingers_[i].has_pose) return false;
  const Isometry3d X_OF = X_SO_.inverse() * fingers_[i].X_SF;
  for (const double behind : {0.0, 1.0, 2.0}) {
    const Vector3d p_O = X_OF * Vector3d(-behind * radius_, 0, 0);
    const auto near = body_->contact->Find(p_O, radius_ + kClear);
    if (!p_O.allFinite() || near) return false;
  }
  return true;
}

void TactileEstimator::UpdateContact(std::size_t i) noexcept {
  if (body_ && fingers_[i].has_pose) {
    finger_contacts_[i].Update(*body_->contact, X_SO_.inverse() * fingers_[i].X_SF,
                               fingertips_[i].touch(), body_->largest_force);
  } else {
    finger_contacts_[i].LetGo();
  }
}

// A body at rest that nothing touches stays so; one in motion moves on.
void TactileEstimator::Deform() noexcept {
  SeparateHeld();
  if (Respond()) return;
  const bool holds = std::ranges::any_of(
      contacts_, [](const Contact& c) { return c.kind == Contact::Kind::kDisplacement; });
  if (holds) {  // what cannot be held so, on supports say, may still be loaded
    for (const std::size_t i : acting_) finger_contacts_[i].ActByForce();
    if (Respond()) return;
  }
  shape_validity_ = Validity::kFailed;
}

// Contacts that prescribe displacements share no node.
void TactileEstimator::SeparateHeld() noexcept {
  for (std::size_t i = 0; i < finger_contacts_.size(); ++i) {
    const Contact& one = finger_contacts_[i].contact();
    if (!finger_contacts_[i].acts() || one.kind != Contact::Kind::kDisplacement) continue;
    for (std::size_t j = 0; j < i; ++j) {
      const Contact& other = finger_contacts_[j].contact();
      if (!finger_contacts_[j].acts() || other.kind != Contact::Kind::kDisplacement) continue;
      const bool overlaps = (one.p_O - other.p_O).norm() <= one.width;
      if (overlaps || SharesNode(*body_, one, other)) finger_contacts_[i].ActByForce();
    }
  }
}

bool TactileEstimator::Respond() noexcept {
  contacts_.clear();
  acting_.clear();
  for (std::size_t i = 0; i < finger_contacts_.size(); ++i) {
    if (!finger_contacts_[i].acts()) continue;
    contacts_.push_back(finger_contacts_[i].contact());
    acting_.push_back(i);
  }
  if (contacts_.empty() && at_rest_) return true;
  body_->deformation->Solve(contacts_, &solution_);
  at_rest_ = contacts_.empty() && !body_->moves_in_time;
  shape_validity_ = Validity::kValid;
  shape_doubt_ = {};
  for (const ContactResponse& response : solution_.responses()) {
    shape_validity_ = Worse(shape_validity_, response.validity);
    if (!response.doubt.empty()) shape_doubt_ = response.doubt;
  }
  return shape_validity_ != Validity::kFailed && body_->deformation->failure().empty();
}

void TactileEstimator::ReportFinger(std::size_t i) noexcept {
  FingerEstimate& finger = fingers_[i];
  const FingerTouch& touch = fingertips_[i].touch();
  const FingerContact& contact = finger_contacts_[i];
  finger.in_contact = touch.touching;
  finger.force.reset();
  if (touch.force_F) finger.force = -(finger.X_SF.linear() * *touch.force_F);
  finger.sigma = touch.sigma;
  // A pose that is turned turns the force, about the two axes across it.
  if (finger.force && finger.has_pose) {
    const double across = pose_tolerance_ * finger.force->norm();
    finger.sigma = std::hypot(finger.sigma, across, across);
  }
  finger.Set(touch);
  finger.Add(contact.verdict());
  if (has_poses_file_ && !finger.has_pose) FlagLostPose(&finger);
  finger.p_S_contact.reset();
  if (contact.has_place()) finger.p_S_contact = X_SO_ * contact.p_O();

  FingerState& state = felt_.fingers[i];
  state.p_S_contact = finger.p_S_contact.value_or(finger.p_S_apex).cast<float>();
  state.force.reset();
  if (finger.force) state.force = finger.force->cast<float>();
  state.in_contact = finger.in_contact;
  state.validity = finger.validity;
}

// The network's force is known, but not the way it points in S.
void TactileEstimator::FlagLostPose(FingerEstimate* finger) const noexcept {
  finger->force.reset();
  finger->sigma = 0;
  finger->Add(
      {Validity::kTrackingLost, FailedCheck::kPose, "the poses file has no pose for this time"});
}

// The first fingertip is the tool.
void TactileEstimator::ReportTool(const TactileFrame& frame, const Vector3d& p_S_tip) noexcept {
  const FingerEstimate& first = fingers_.front();
  const bool was_touching = felt_.local_model.in_contact;
  felt_.sample = frame.sequence;
  felt_.sensed_at = frame.sensed_at;
  felt_.events.Clear();
  if (first.has_pose) {
    felt_.p_S_tip = first.p_S_apex;
  } else if (p_S_tip.allFinite()) {
    felt_.p_S_tip = p_S_tip;
  }
  felt_.force = first.force;
  felt_.sigma = first.sigma;
  felt_.Set(first);
  felt_.details.rest_drift = touch(0).drift;
  felt_.local_model.in_contact = first.in_contact;
  felt_.p_S_contact = first.p_S_contact.value_or(felt_.p_S_tip);
  felt_.depth = 0;
  if (body_ && first.has_pose) {
    std::optional<FingerLocalModel::FeltForce> felt;
    if (first.in_contact && first.force && first.validity == Validity::kValid) {
      felt = {*first.force, first.sigma};
    }
    local_touch_->Update(*body_, X_SO_, first.X_SF, first.in_contact, felt, &felt_.local_model);
    if (!first.p_S_contact) felt_.p_S_contact = X_SO_ * local_touch_->p_O();
    if (first.force && touch(0).stirs) CompareStiffness();
    felt_.depth = first.in_contact ? std::max(0.0, local_touch_->depth()) : 0;
  }
  if (first.in_contact != was_touching) {
    felt_.events.Add(first.in_contact ? Event::kContact : Event::kRelease);
  }
  const bool is_known = IsForceKnown(felt_.validity);
  if (is_known != was_known_) {
    felt_.events.Add(is_known ? Event::kTrackingRegained : Event::kTrackingLost);
    was_known_ = is_known;
  }
}

// The object's model is off by tens of percent, more where the contact is shallow; a force that is
// off by more is not that of this object at this depth.
void TactileEstimator::CompareStiffness() noexcept {
  FingerEstimate& first = fingers_.front();
  const double depth = local_touch_->depth() / press_depth_;
  if (!(depth > kTellingDepth) || first.validity != Validity::kValid) return;
  const auto [least, most] =
      depth > kDeep ? std::pair(kLeastDeep, kMostDeep) : std::pair(kLeastShallow, kMostShallow);
  const double normal = first.force->dot(felt_.local_model.normal);
  const auto [lower, upper] = local_touch_->modelled();
  if (normal + first.sigma > least * lower && normal - first.sigma < most * upper) return;
  Fail(0, FailedCheck::kTransfer, "the force does not match that of the model at this depth");
}

// A sample that shows the fingertip where the arm was before tells the force of then.
void TactileEstimator::CompareWithEncoders(const EncoderReading& said) noexcept {
  FingerEstimate& first = fingers_.front();
  if (fingertips_.front().misses()) return;  // the frame is an old one
  const bool agree = arm_.Agree(first.p_S_apex, said, kArmApart);
  arm_doubts_ = agree ? std::max(arm_doubts_ - 1, 0) : kArmForgives;
  for (std::size_t i = 0; arm_doubts_ > 0 && i < fingertips_.size(); ++i) {
    Fail(i, FailedCheck::kArm, "the fingertips are not where the encoders report them");
  }
  if (!first.force || !(arm_.apart() > 0)) return;
  const Vector3d& n = felt_.local_model.normal;
  const double slope = n.dot(felt_.local_model.stiffness * n);
  if (!std::isfinite(slope)) return;
  // The arm carries all of them, on the same object.
  for (FingerEstimate& finger : std::span(fingers_).first(fingertips_.size())) {
    finger.sigma = std::hypot(finger.sigma, slope * arm_.apart());
  }
  felt_.sigma = first.sigma;
}

// Once its state has been told.
void TactileEstimator::Fail(std::size_t i, FailedCheck check, std::string_view why) noexcept {
  FingerEstimate& finger = fingers_[i];
  finger.Fail(check, why);
  felt_.fingers[i].validity = finger.validity;
  if (i == 0) felt_.Set(finger);
}

LocalModel TactileEstimator::LocalAt(const Vector3d& p_S_tip) noexcept {
  const FingerEstimate& first = fingers_.front();
  if (!body_ || !first.has_pose || !p_S_tip.allFinite()) return felt_.local_model;
  Isometry3d X_SF = first.X_SF;
  X_SF.translation() += p_S_tip - first.p_S_apex;
  local_touch_->Follow(*body_, X_SO_, X_SF, first.in_contact, &felt_.local_model);
  return felt_.local_model;
}

bool TactileEstimator::MakePatch(const Vector3d& p_S_tip, SurfacePatch* patch) noexcept {
  const FingerEstimate& first = fingers_.front();
  if (!body_ || !first.has_pose || !p_S_tip.allFinite()) return false;
  Isometry3d X_SF = first.X_SF;
  X_SF.translation() += p_S_tip - first.p_S_apex;
  return local_touch_->MakePatch(*body_, X_SO_, X_SF, patch);
}

void TactileEstimator::DeformedNodes(std::vector<Vector3d>* p_S) {
  p_S->clear();
  if (!body_) return;
  body_->deformation->Displacements(solution_, p_S);
  for (std::size_t i = 0; i < p_S->size(); ++i) {
    (*p_S)[i] = X_SO_ * Vector3d(body_->surface.nodes[i] + (*p_S)[i]);
  }
}

}  // namespace palpate
