#include "slave/pipeline/fingertips/tactile_estimator.h"

#include <algorithm>
#include <cmath>
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
constexpr double kSilence = 100;    // periods; longer gaps are treated alike
// Distance between skin and object above which there is no contact, for any pose [m].
constexpr double kClear = 5e-3;
// Smallest depth at which force and model are compared, relative to the scene's press [-]. [tuned:
// object softer than stated]
constexpr double kDeep = 0.6;
constexpr double kArmApart = 5e-4;  // distance of fingertip and encoder pose that is followed [m]

Isometry3d Carried(const Finger& finger, const Vector3d& way) {
  Isometry3d X_SF = finger.X_SF;
  if (finger.motion == Finger::Motion::kHand) X_SF.translation() += way;
  if (finger.motion == Finger::Motion::kOpposite) X_SF.translation() -= way;
  return X_SF;
}

// A signal that a recording lacks would read 0 at rest and in contact, an undetected error of a
// network that uses it. Throws std::runtime_error naming the column.
void RequireSignals(const Tactile& tactile, const ForceNetwork& network) {
  const bool takes_all =
      tactile.channels.are_electrodes() && network.info().inputs > kElectrodeCount;
  if (tactile.source != Tactile::Source::kRecording || !takes_all) return;
  std::vector<std::string> wanted;
  for (const Finger& finger : tactile.fingers) wanted.push_back(finger.name);
  for (const RecordedFinger& finger : ReadTactileFingers(tactile.file, wanted)) {
    const std::string missing = finger.MissingColumn();
    if (missing.empty()) continue;
    throw std::runtime_error(
        fmt::format("{}: no column {}: {} needs E1 to E19, pac0 and pdc; without them expected a "
                    "network that uses only the electrodes",
                    tactile.file.string(), missing, tactile.network.string()));
  }
}

// Throws std::invalid_argument naming the key if the network is for other channels.
void RequireChannels(const Scene& scene, const NetworkInfo& info) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  const auto refuse = [&](const char* key, const auto& value, const auto& expected) {
    throw std::invalid_argument(
        fmt::format("{}: sense.tactile.{} = {}: expected {}, for which {} was trained",
                    scene.file.string(), key, value, expected, tactile.network.string()));
  };
  if (tactile.channels.count != info.channels.count) {
    refuse("channels", tactile.channels.count, info.channels.count);
  }
  if (tactile.channels.unit != info.channels.unit) {
    refuse("unit", tactile.channels.unit, info.channels.unit);
  }
}

// Without a layout every contact is at the pad's apex.
ElectrodeLayout LayoutOf(const Tactile& tactile) {
  if (!tactile.electrodes.empty()) return ReadElectrodeLayout(tactile.electrodes, tactile.channels);
  if (tactile.channels.are_electrodes()) return SimulatedLayout(tactile.finger_radius);
  ElectrodeLayout apex(tactile.channels.count);
  std::ranges::fill(apex.p_F, Vector3d(0, 0, -tactile.finger_radius));
  std::ranges::fill(apex.n_F, -Vector3d::UnitZ());
  return apex;
}

// Loads a file named in the scene; a failure makes the scene unusable.
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
          fmt::format("{}: sense.tactile.rate = {:g} Hz: expected {:g} Hz, for which {} was "
                      "trained",
                      scene.file.string(), tactile.rate, rate, tactile.network.string()));
    }
    RequireChannels(scene, senses.network->info());
    RequireSignals(tactile, *senses.network);
  }
  const ElectrodeLayout layout =
      NamingTheKey(scene, "electrodes", [&] { return LayoutOf(tactile); });
  if (!tactile.channels.are_electrodes()) {
    const NetworkInfo info = senses.network ? senses.network->info() : NetworkInfo{};
    if (MeetsObject(scene) && tactile.electrodes.empty() && !info.gives_contact_point) {
      throw std::invalid_argument(
          fmt::format("{}: sense.tactile.electrodes is missing: expected a layout of {}, or a "
                      "network with contact_point, because the scene has a pose",
                      scene.file.string(), tactile.channels.Names()));
    }
    senses.localiser = MakeChannelLocaliser(info.noise, layout);
    return senses;
  }
  senses.localiser =
      NamingTheKey(scene, "electrodes", [&] { return MakeLocaliser(tactile, layout); });
  return senses;
}

TactileEstimator::TactileEstimator(const Scene& scene)
    : TactileEstimator(scene, LoadSenses(scene)) {}

TactileEstimator::TactileEstimator(const Scene& scene, TactileSenses senses)
    : tactile_(*scene.sense.Find<Tactile>()),
      p_S_home_(scene.manipulator.home),
      press_depth_(scene.operator_options.press_depth),
      senses_(std::move(senses)),
      checks_(tactile_.fingers.size()),
      object_(scene) {
  for (std::size_t i = 0; i < checks_.size(); ++i) {
    fingertips_.emplace_back(tactile_, senses_.network.get(), *senses_.localiser);
  }
  if (checks_.size() > 1) estimate_.finger_count = finger_count();
  Adopt(Prepare(scene), scene);
}

std::unique_ptr<TactileBody> TactileEstimator::Prepare(const Scene& scene, Progress* progress) {
  return MeetsObject(scene) ? MakeTactileBody(scene, progress) : nullptr;
}

void TactileEstimator::Adopt(std::unique_ptr<TactileBody> body, const Scene& scene) {
  object_.Adopt(std::move(body));
  local_touch_.emplace(scene);
  last_shape_ = {};
}

void TactileEstimator::Reset() noexcept {
  for (Fingertip& fingertip : fingertips_) fingertip.Reset();
  for (FingerChecks& finger : checks_) finger.consistency.Reset();
  object_.Reset();
  last_shape_ = {};
  local_touch_->Forget();
  arm_.Reset();
}

const ContactEstimate& TactileEstimator::Estimate(const TactileFrame& frame,
                                                  const Vector3d& p_S_tip,
                                                  const std::optional<double>& arm_lag) noexcept {
  Stopwatch total, lap;
  Observe(frame, p_S_tip);
  times_.tactile.Add(lap.Lap());
  estimate_.processed_at = Clock::now();
  for (std::size_t i = 0; i < fingertips_.size(); ++i) {
    object_.Touch(i, fingers_[i].has_pose ? &fingers_[i].X_SF : nullptr, fingertips_[i].touch());
  }
  times_.contact.Add(lap.Lap());
  object_.Deform();
  // Samples without contact are excluded, because they take less time.
  const double mechanics = lap.Lap();
  if (!object_.contacts().empty()) times_.mechanics.Add(mechanics);
  const auto encoder_error = EncoderError(frame, p_S_tip, arm_lag);
  for (std::size_t i = 0; i < fingertips_.size(); ++i) EstimateFinger(i, encoder_error);
  double checks_us = lap.Lap();
  for (const Fingertip& fingertip : fingertips_) checks_us += fingertip.checks_us();
  times_.checks.Add(checks_us);
  EstimateTool(frame, p_S_tip);
  EstimateMoment();
  times_.total.Add(total.Lap());
  return estimate_;
}

void TactileEstimator::Observe(const TactileFrame& frame, const Vector3d& p_S_tip) noexcept {
  const int missing = MissingBefore(frame);
  for (std::size_t i = 0; i < fingertips_.size(); ++i) {
    for (int k = 0; k < missing; ++k) fingertips_[i].Estimate(FingerReading{}, false);
    Locate(i, frame.fingers[i], p_S_tip);
    // There is no contact even with the largest error of the pose.
    const double gap = -fingers_[i].depth.value_or(0);
    fingertips_[i].Estimate(frame.fingers[i], frame.after_gap && missing == 0,
                            gap > kClear && std::isfinite(gap));
  }
}

// Returns the number of missing samples since the last one by the timestamps, limited to that of a
// silence; 0: unknown.
int TactileEstimator::MissingBefore(const TactileFrame& frame) const noexcept {
  const double periods = SecondsBetween(estimate_.sensed_at, frame.sensed_at) * tactile_.rate;
  if (estimate_.sample == 0 || !(periods > 1.5)) return 0;
  return static_cast<int>(std::min(std::round(periods), kSilence)) - 1;
}

void TactileEstimator::Locate(std::size_t i, const FingerReading& reading,
                              const Vector3d& p_S_tip) noexcept {
  FingerEstimate& finger = fingers_[i];
  const Finger& stated = tactile_.fingers[i];
  finger.has_pose = reading.X_SF.has_value() || stated.has_pose;
  if (reading.X_SF) {
    finger.X_SF = *reading.X_SF;
  } else if (finger.has_pose && p_S_tip.allFinite()) {
    finger.X_SF = Carried(stated, p_S_tip - p_S_home_);
  }
  if (!finger.X_SF.matrix().allFinite()) {
    finger.has_pose = false;
    finger.X_SF = Isometry3d::Identity();
  }
  finger.p_S_apex = finger.X_SF * Vector3d(0, 0, -tactile_.finger_radius);
  finger.depth = finger.has_pose ? object_.DepthOf(finger.X_SF) : std::nullopt;
}

std::optional<double> TactileEstimator::EncoderError(
    const TactileFrame& frame, const Vector3d& p_S_tip,
    const std::optional<double>& arm_lag) noexcept {
  const bool is_compared = arm_lag && frame.fingers.front().X_SF;
  // Otherwise the value belongs to an old frame.
  if (!is_compared || fingertips_.front().misses()) return std::nullopt;
  arm_.Agree(fingers_.front().p_S_apex, {p_S_tip, *arm_lag}, kArmApart);
  return arm_.apart();
}

void TactileEstimator::EstimateFinger(std::size_t i,
                                      const std::optional<double>& encoder_error) noexcept {
  FingerEstimate& finger = fingers_[i];
  const FingerTouch& touch = fingertips_[i].touch();
  const FingerContact& contact = object_.contact(static_cast<int>(i));
  finger.in_contact = touch.touching;
  finger.force.reset();
  if (touch.force_F) finger.force = -(finger.X_SF.linear() * *touch.force_F);
  finger.sigma = touch.sigma;
  finger.Set(touch);
  CheckFinger(i, encoder_error);
  // An error of the pose rotates the force about the two axes normal to it.
  if (finger.force && finger.has_pose) {
    const double across = tactile_.pose_tolerance * finger.force->norm();
    finger.sigma = std::hypot(finger.sigma, across, across);
  }
  finger.p_S_contact.reset();
  if (contact.has_place()) finger.p_S_contact = object_.X_SO() * contact.place().p_O;

  FingerState& state = estimate_.fingers[i];
  state.p_S_contact = finger.p_S_contact.value_or(finger.p_S_apex).cast<float>();
  state.force.reset();
  if (finger.force) state.force = finger.force->cast<float>();
  state.in_contact = finger.in_contact;
  state.validity = finger.validity;
}

void TactileEstimator::CheckFinger(std::size_t i,
                                   const std::optional<double>& encoder_error) noexcept {
  FingerEstimate& finger = fingers_[i];
  const FingerContact& contact = object_.contact(static_cast<int>(i));
  auto& [checks, consistency] = checks_[i];
  FingertipSample sample{fingertips_[i], &consistency, finger.depth, contact.misplaced(),
                         contact.is_beyond_model()};
  sample.encoder_error = encoder_error;
  const bool is_deep = local_touch_->depth() > kDeep * press_depth_;
  if (i == 0 && body() != nullptr && finger.force && finger.has_pose && is_deep) {
    const double force = finger.force->dot(estimate_.local_model.normal);
    sample.force_ratio = force / local_touch_->modelled();
    sample.force_ratio_sigma = finger.sigma / force;
  }
  const Findings findings = checks.Examine(sample);
  finger.Add(findings.verdict);
  const auto [verdict, widening] = consistency.Close();
  finger.Add(verdict);
  finger.sigma *= widening;
  // Computes the force error from the distance to the encoder pose, with the local model of the
  // last sample.
  const Vector3d& n = estimate_.local_model.normal;
  const double slope = n.dot(estimate_.local_model.stiffness * n);
  if (finger.force && std::isfinite(slope)) {
    finger.sigma = std::hypot(finger.sigma, slope * std::max(0.0, encoder_error.value_or(0)));
  }
}

// The first fingertip is the tool.
void TactileEstimator::EstimateTool(const TactileFrame& frame, const Vector3d& p_S_tip) noexcept {
  const FingerEstimate& first = fingers_.front();
  const bool was_touching = estimate_.local_model.in_contact;
  estimate_.sample = frame.sequence;
  estimate_.sensed_at = frame.sensed_at;
  estimate_.events.Clear();
  if (first.has_pose) {
    estimate_.p_S_tip = first.p_S_apex;
  } else if (p_S_tip.allFinite()) {
    estimate_.p_S_tip = p_S_tip;
  }
  estimate_.force = first.force;
  estimate_.sigma = first.sigma;
  estimate_.Set(first);
  estimate_.details.rest_drift = touch(0).drift;
  UpdateLocalModel();
  if (first.in_contact != was_touching) {
    estimate_.events.Add(first.in_contact ? Event::kContact : Event::kRelease);
  }
  const bool is_known = IsForceKnown(estimate_.validity);
  if (is_known != was_known_) {
    estimate_.events.Add(is_known ? Event::kTrackingRegained : Event::kTrackingLost);
    was_known_ = is_known;
  }
}

void TactileEstimator::UpdateLocalModel() noexcept {
  const FingerEstimate& first = fingers_.front();
  estimate_.local_model.in_contact = first.in_contact;
  estimate_.p_S_contact = first.p_S_contact.value_or(estimate_.p_S_tip);
  estimate_.depth = 0;
  if (body() == nullptr || !first.has_pose) return;
  std::optional<FingerLocalModel::MeasuredForce> measured;
  if (first.in_contact && first.force && first.validity == Validity::kValid) {
    measured = {*first.force, first.sigma};
  }
  local_touch_->Update(*body(), object_.X_SO(), first.X_SF, first.in_contact, measured,
                       &estimate_.local_model);
  if (!first.p_S_contact) estimate_.p_S_contact = object_.X_SO() * local_touch_->p_O();
  estimate_.depth = first.in_contact ? std::max(0.0, local_touch_->depth()) : 0;
}

// The measured force at the measured contact point, distributed over the patch as the model
// distributes its own.
void TactileEstimator::EstimateMoment() noexcept {
  const FingerEstimate& first = fingers_.front();
  estimate_.moment.reset();
  if (tactile_.patch == 0 || body() == nullptr || !first.force || !first.has_pose) return;
  if (!first.in_contact) {
    estimate_.moment = Vector3d::Zero();
    estimate_.moment_sigma = estimate_.sigma * tactile_.patch / 2;
    return;
  }
  const ContactResponse* response = object_.ResponseOf(0);
  if (response == nullptr || response->validity == Validity::kFailed || !response->moment_O) return;
  const double force = first.force->norm(), modelled = response->force_O.norm();
  if (!(force > 0) || !(modelled > 0)) return;
  const TouchPlace& place = touch(0).place;
  const Vector3d arm = first.X_SF * place.p_F - first.p_S_apex;
  const double share = force / modelled;
  estimate_.moment =
      arm.cross(*first.force) - share * (object_.X_SO().linear() * *response->moment_O);
  const double place_sigma = place.sigma > 0 ? place.sigma : tactile_.patch / 2;
  const double lever = std::max(arm.norm(), estimate_.moment->norm() / force);
  // The error bound of the model changes the ratio.
  const double bound = response->force_error / modelled * share * response->moment_O->norm();
  estimate_.moment_sigma = std::hypot(std::hypot(share * response->moment_sigma, bound),
                                      std::hypot(force * place_sigma, lever * estimate_.sigma));
}

std::optional<Isometry3d> TactileEstimator::PoseAt(const Vector3d& p_S_tip) const {
  const FingerEstimate& first = fingers_.front();
  if (body() == nullptr || !first.has_pose || !p_S_tip.allFinite()) return std::nullopt;
  Isometry3d X_SF = first.X_SF;
  X_SF.translation() += p_S_tip - first.p_S_apex;
  return X_SF;
}

LocalModel TactileEstimator::LocalAt(const Vector3d& p_S_tip) noexcept {
  if (const auto X_SF = PoseAt(p_S_tip)) {
    local_touch_->Follow(*body(), object_.X_SO(), *X_SF, fingers_.front().in_contact,
                         &estimate_.local_model);
  }
  return estimate_.local_model;
}

bool TactileEstimator::MakePatch(const Vector3d& p_S_tip, SurfacePatch* patch) noexcept {
  const auto X_SF = PoseAt(p_S_tip);
  return X_SF && local_touch_->MakePatch(*body(), object_.X_SO(), *X_SF, patch);
}

}  // namespace palpate
