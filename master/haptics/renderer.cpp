#include "master/haptics/renderer.h"

#include <algorithm>
#include <cmath>

namespace palpate {
namespace {

constexpr double kMaxEntry = 1e12;

bool IsSameContact(const LocalModel& a, const LocalModel& b) {
  return a.revision == b.revision && a.reference == b.reference && a.normal == b.normal &&
         a.force == b.force && a.stiffness == b.stiffness && a.in_contact == b.in_contact;
}

template <class Matrix>
bool IsModest(const Matrix& m) {
  return m.allFinite() && m.cwiseAbs().maxCoeff() <= kMaxEntry;
}

constexpr std::array<std::string_view, 3> kModes{"local", "interpolate", "hold"};
constexpr double kNoticeable = 0.01;  // relative change of K
constexpr double kLowering = 0.01;    // of the transport delay [s/s]

// Moves `share` by one `step` towards 1 if it is `wanted`, else towards 0.
double Towards(bool wanted, double step, double share) {
  return wanted ? std::min(1.0, share + step) : std::max(0.0, share - step);
}

}  // namespace

void LocalContact::Take(const LocalModel& model, double now) noexcept {
  if (!model.known() || (known() && IsSameContact(model, to_))) return;
  if (known()) {
    from_ = At(now);
  } else {
    from_ = model;
    from_.force.setZero();
    from_.stiffness.setZero();
  }
  // The slave reports the end of contact, possibly late: the contact stays until the tip is
  // outside.
  if (entry_ && to_.in_contact && !model.in_contact) entry_ = from_.reference;
  to_ = model;
  since_ = now;
}

Eigen::Vector3d LocalContact::ForceAt(const Eigen::Vector3d& p_S, double now) noexcept {
  if (!known()) return {0, 0, 0};
  if (!(At(now).Penetration(p_S) > 0)) {
    EndContact();
    return {0, 0, 0};
  }
  if (!entry_) entry_ = p_S;
  const LocalModel model = At(now);
  const Eigen::Vector3d force = model.force + model.stiffness * (model.reference - p_S);
  // The tangent of a stiffening curve is negative near the surface, where the contact does not
  // pull.
  const bool pulls = model.force.dot(model.normal) < 0 && force.dot(model.normal) < 0;
  return pulls ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : force;
}

LocalModel LocalContact::At(double now) const noexcept {
  const double share = std::clamp((now - since_) / kBlendTime, 0.0, 1.0);
  LocalModel model = to_;
  if (share < 1) {
    model.reference = from_.reference + share * (to_.reference - from_.reference);
    model.force = from_.force + share * (to_.force - from_.force);
    model.stiffness = from_.stiffness + share * (to_.stiffness - from_.stiffness);
    const Eigen::Vector3d normal = from_.normal + share * (to_.normal - from_.normal);
    if (normal.norm() > 0.1) model.normal = normal.normalized();  // else opposite: the new one
  }
  if (entry_ && !model.in_contact) {  // along the plane: n . x_r stays
    model.reference = *entry_ + model.Penetration(*entry_) * model.normal;
  }
  return model;
}

bool LocalContact::IsBeyond(const Eigen::Vector3d& p_S) const noexcept {
  return known() && to_.valid_radius > 0 && (p_S - to_.reference).norm() > to_.valid_radius;
}

bool IsSane(const LocalModel& model) noexcept {
  return IsModest(model.reference) && IsModest(model.normal) && IsModest(model.force) &&
         IsModest(model.stiffness) && std::isfinite(model.valid_radius) &&
         std::abs(model.normal.norm() - 1) < 0.01;
}

void DelayedLinear::Add(double stamp, double arrival, const Eigen::Vector3d& force) noexcept {
  if (count_ > 0 && !(stamp > samples_[0].stamp)) return;
  const double lowered = count_ > 0 ? transport_ - kLowering * (stamp - samples_[0].stamp) : 0;
  transport_ = std::max({0.0, lowered, arrival - stamp});
  std::move_backward(samples_.begin(), samples_.end() - 1, samples_.end());
  samples_[0] = {stamp, force};
  count_ = std::min(count_ + 1, kMaxKept);
}

Eigen::Vector3d DelayedLinear::At(double now) const noexcept {
  if (count_ < 2) return samples_[0].force;
  const double shown = now - (samples_[0].stamp - samples_[1].stamp) - transport_;
  if (shown >= samples_[0].stamp) return samples_[0].force;
  for (int i = 1; i < count_; ++i) {
    const Sample& from = samples_[static_cast<std::size_t>(i)];
    const Sample& to = samples_[static_cast<std::size_t>(i) - 1];
    if (shown < from.stamp) continue;
    const double share = (shown - from.stamp) / (to.stamp - from.stamp);
    return from.force + share * (to.force - from.force);
  }
  return samples_[static_cast<std::size_t>(count_) - 1].force;
}

std::string_view ToString(RenderMode mode) {
  return kModes[static_cast<std::size_t>(mode)];
}

std::optional<RenderMode> ParseRenderMode(std::string_view text) {
  const auto* found = std::find(kModes.begin(), kModes.end(), text);
  if (found == kModes.end()) return std::nullopt;
  return static_cast<RenderMode>(found - kModes.begin());
}

void Renderer::Take(const SlaveState& state, double sensed, double arrived, double now) noexcept {
  if (IsForceKnown(state.validity)) punctured_ = state.validity == Validity::kPunctured;
  LocalModel model = state.local_model;
  model.stiffness = NearestSpring(model.stiffness, stiffest_);
  projected_ = (model.stiffness - state.local_model.stiffness).norm() >
               kNoticeable * state.local_model.stiffness.norm();
  contact_.Take(model, now);
  if (model.known()) {
    const LocalModel& reported = state.local_model;
    reported_stiffness_ = reported.normal.dot(reported.stiffness * reported.normal);
  }
  if (IsForceKnown(state)) samples_.Add(sensed, std::max(sensed, arrived), *state.force);
}

Eigen::Vector3d Renderer::Render(const Eigen::Vector3d& p_S, double now,
                                 Reasons* reasons) noexcept {
  const double dt = std::max(0.0, now - last_);
  last_ = now;
  presence_ = punctured_ ? std::max(0.0, presence_ - dt / kPunctureTime)
                         : std::min(1.0, presence_ + dt / kReturnTime);
  if (presence_ < 1) reasons->Add(Reason::kPunctured);
  if (mode_ == RenderMode::kHold) return presence_ * samples_.newest();
  if (mode_ == RenderMode::kInterpolate) return presence_ * samples_.At(now);
  return presence_ * RenderLocal(p_S, now, dt, reasons);
}

Eigen::Vector3d Renderer::RenderLocal(const Eigen::Vector3d& p_S, double now, double dt,
                                      Reasons* reasons) noexcept {
  const PatchContact& patch = patch_.newest();
  const Eigen::Vector3d by_patch = patch_.ForceAt(p_S, now, now + ahead_);
  const bool is_learnt = patch_.known() && patch.patch().is_learnt();
  const Eigen::Vector3d by_plane = contact_.ForceAt(p_S, now);
  const bool serves = patch_.known() && patch.serves();
  on_patch_ = Towards(serves, dt / kStepTime, on_patch_);
  held_share_ = Towards(selector_.prefers_hold(), dt / kStepTime, held_share_);

  if (on_patch_ < 1) {
    if (patch_.known()) reasons->Add(Reason::kPlane);
    if (projected_) reasons->Add(Reason::kProjected);
    if (contact_.IsBlending(now)) reasons->Add(Reason::kBlending);
    if (contact_.IsBeyond(p_S)) reasons->Add(Reason::kBeyondModel);
  }
  if (on_patch_ > 0) {
    if (patch.is_capped()) reasons->Add(Reason::kProjected);
    if (patch_.IsBlending(now)) reasons->Add(Reason::kBlending);
    if (patch.is_beyond()) reasons->Add(Reason::kBeyondModel);
  }
  if (held_share_ > 0) reasons->Add(Reason::kHeld);
  const Eigen::Vector3d model = by_plane + on_patch_ * (by_patch - by_plane);
  const bool says_something = contact_.known() || patch_.known();
  if (says_something) selector_.Show(now, model, samples_.newest());
  const Eigen::Vector3d best = is_learnt ? Corrected(model, now) : model;
  return best + held_share_ * (samples_.newest() - best);
}

Eigen::Vector3d Renderer::Corrected(const Eigen::Vector3d& model, double now) const noexcept {
  if (model.isZero(0)) return model;  // no correction without contact
  const double news = std::exp(-std::max(0.0, now - missed_at_) / kNews);
  const Eigen::Vector3d corrected = model + on_patch_ * news * missing_;
  const Eigen::Vector3d out = model.normalized();
  return corrected - std::min(0.0, corrected.dot(out)) * out;  // a contact never pulls
}

void Renderer::CompareWithSlave(double commanded, const SlaveState& state) noexcept {
  if (mode_ == RenderMode::kLocal && IsForceKnown(state) && !punctured_) {
    missing_ = selector_.Compare(commanded, *state.force, state.sigma);
    missed_at_ = commanded;
  }
}

}  // namespace palpate
