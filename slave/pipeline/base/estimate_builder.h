// Rules for every contact estimate, independent of the sensing: events are reported once, the force
// is zero after a puncture, and the uncertainty of E is part of the force's sigma.
#pragma once

#include <cmath>
#include <optional>

#include "shared/state/slave_state.h"
#include "slave/scene/scene.h"

namespace palpate {

// `next` as the successor of `last`: gets a new revision if something changed.
inline LocalModel Revised(LocalModel next, const LocalModel& last) noexcept {
  const bool same = next.reference == last.reference && next.normal == last.normal &&
                    next.stiffness == last.stiffness;
  next.revision = same && last.known() ? last.revision : last.revision + 1;
  return next;
}

// The estimates of one pipeline. For each estimate: Track, then Touch and SetForce, or LoseForce.
class EstimateBuilder {
 public:
  // Uses puncture depth and tolerance of E from the scene.
  void Adopt(const Scene& scene) noexcept {
    puncture_depth_ = scene.model.puncture_depth;
    modulus_tolerance_ = scene.object.material.young_modulus_tolerance;
  }
  void Reset() noexcept { in_contact_ = punctured_ = is_broken_ = false; }

  // Sets whether the tracked object or tool was found.
  void Track(bool found, ContactEstimate* estimate) noexcept {
    if (found == tracking_) return;
    estimate->events.Add(found ? Event::kTrackingRegained : Event::kTrackingLost);
    tracking_ = found;
  }

  // Sets whether the tool touches.
  void Touch(bool touches, ContactEstimate* estimate) noexcept {
    if (touches != in_contact_) estimate->events.Add(touches ? Event::kContact : Event::kRelease);
    in_contact_ = touches;
    if (!touches) punctured_ = is_broken_ = false;
  }
  [[nodiscard]] bool in_contact() const { return in_contact_; }
  // Records a puncture: the force is zero until the tool has left.
  void Break() noexcept { is_broken_ = true; }
  [[nodiscard]] bool broken() const { return is_broken_; }

  // The force of a model with modulus E, frame S [N], and the part of its sigma that is independent
  // of the model [N]; `verdict` is that of the model; `estimate` has its depth.
  void SetForce(const Eigen::Vector3d& force, double sigma, const Verdict& verdict,
                ContactEstimate* estimate) noexcept {
    estimate->force = force;
    estimate->Set(verdict);
    const bool is_beyond = verdict.validity == Validity::kExtrapolated;
    if (is_beyond && verdict.check == FailedCheck::kNone)
      estimate->check = FailedCheck::kModelRange;
    const bool overshot = puncture_depth_ > 0 && estimate->depth > puncture_depth_;
    const bool through = in_contact_ && (overshot || is_broken_);
    if (through && !punctured_) estimate->events.Add(Event::kPuncture);
    punctured_ |= through;
    if (punctured_) {  // the puncture cue of paper A, 4.2: the force becomes zero
      estimate->force = Eigen::Vector3d::Zero();
      estimate->Set({Validity::kPunctured});
    }
    estimate->sigma = std::hypot(sigma, modulus_tolerance_ * estimate->force->norm());
  }

  // Call after SetForce. Sets the moment of the force about the tip, frame S [N m], and the part of
  // its sigma that is independent of the force's sigma; nullopt: unknown. Without contact the
  // moment is zero, and the force's sigma acts at a distance of up to `reach` from the tip [m].
  void SetMoment(const std::optional<Eigen::Vector3d>& moment, double sigma, double reach,
                 ContactEstimate* estimate) const noexcept {
    const double force = estimate->force ? estimate->force->norm() : 0;
    estimate->moment = moment;
    if (!in_contact_ || force == 0) {
      estimate->moment = Eigen::Vector3d::Zero();
      estimate->moment_sigma = reach * estimate->sigma;
    } else if (moment) {
      estimate->moment_sigma = std::hypot(sigma, moment->norm() * estimate->sigma / force);
    }
  }

  static void LoseForce(const Verdict& verdict, ContactEstimate* estimate) noexcept {
    estimate->force.reset();
    estimate->moment.reset();
    estimate->sigma = 0;
    estimate->Set(verdict);
  }

 private:
  double puncture_depth_ = 0;     // [m]; 0: never
  double modulus_tolerance_ = 0;  // one sigma of E, relative [-]
  bool tracking_ = true, in_contact_ = false, punctured_ = false, is_broken_ = false;
};

}  // namespace palpate
