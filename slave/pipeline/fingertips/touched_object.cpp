#include "slave/pipeline/fingertips/touched_object.h"

#include <algorithm>
#include <utility>

namespace palpate {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

bool SharesNode(const TactileBody& body, const TouchedPlace& a, const TouchedPlace& b) {
  const auto& one = body.surface.triangles[static_cast<std::size_t>(a.triangle)];
  const auto& other = body.surface.triangles[static_cast<std::size_t>(b.triangle)];
  return std::ranges::any_of(one, [&](int i) { return std::ranges::count(other, i) > 0; });
}

bool IsDisplaced(const FingerContact& finger) {
  return finger.acts() && finger.contact().kind == Contact::Kind::kDisplacement;
}

}  // namespace

TouchedObject::TouchedObject(const Scene& scene)
    : X_SO_(scene.object.X_SO), radius_(scene.sense.Find<Tactile>()->finger_radius) {
  const Tactile& tactile = *scene.sense.Find<Tactile>();
  fingers_.assign(tactile.fingers.size(), FingerContact(tactile));
  contacts_.reserve(fingers_.size());
  acting_.reserve(fingers_.size());
}

void TouchedObject::Adopt(std::unique_ptr<TactileBody> body) noexcept {
  body_ = std::move(body);
  for (FingerContact& finger : fingers_) finger.EndContact();
  contacts_.clear();
  solution_ = {};
  acting_.clear();
  at_rest_ = true;
}

void TouchedObject::Reset() noexcept {
  Adopt(std::move(body_));
  if (body_) body_->deformation->Reset();
}

std::optional<double> TouchedObject::DepthOf(const Isometry3d& X_SF) const noexcept {
  if (!body_) return std::nullopt;
  return DepthBelow(*body_->contact, X_SO_.inverse() * X_SF, radius_);
}

void TouchedObject::Touch(std::size_t i, const Isometry3d* X_SF,
                          const FingerTouch& touch) noexcept {
  if (!body_ || X_SF == nullptr) return fingers_[i].EndContact();
  fingers_[i].Update(*body_->contact, X_SO_.inverse() * *X_SF, touch,
                     {body_->largest_force, body_->has_friction});
}

// A body at rest without contact is not computed; a body in motion is.
void TouchedObject::Deform() noexcept {
  if (!body_) return;
  SeparateHeld();
  if (Respond()) return;
  const bool holds = std::ranges::any_of(fingers_, IsDisplaced);
  // A displacement may be impossible, for example on supports, where a load is possible.
  if (holds) {
    for (const std::size_t i : acting_) fingers_[i].ActByForce();
    if (Respond()) return;
  }
  validity_ = Validity::kFailed;
}

// Contacts that prescribe displacements share no node.
void TouchedObject::SeparateHeld() noexcept {
  for (std::size_t i = 0; i < fingers_.size(); ++i) {
    for (std::size_t j = 0; j < i && IsDisplaced(fingers_[i]); ++j) {
      if (!IsDisplaced(fingers_[j])) continue;
      const TouchedPlace &one = fingers_[i].place(), &other = fingers_[j].place();
      const bool overlaps = (one.p_O - other.p_O).norm() <= fingers_[i].contact().width;
      if (overlaps || SharesNode(*body_, one, other)) fingers_[i].ActByForce();
    }
  }
}

bool TouchedObject::Respond() noexcept {
  contacts_.clear();
  acting_.clear();
  for (std::size_t i = 0; i < fingers_.size(); ++i) {
    if (!fingers_[i].acts()) continue;
    contacts_.push_back(fingers_[i].contact());
    acting_.push_back(i);
  }
  if (contacts_.empty() && at_rest_) return true;
  body_->deformation->Solve(contacts_, &solution_);
  at_rest_ = contacts_.empty() && !body_->moves_in_time;
  validity_ = Validity::kValid;
  flag_reason_ = {};
  for (const ContactResponse& response : solution_.responses()) {
    validity_ = Worse(validity_, response.validity);
    if (!response.flag_reason.empty()) flag_reason_ = response.flag_reason;
  }
  return validity_ != Validity::kFailed && body_->deformation->failure().empty();
}

const ContactResponse* TouchedObject::ResponseOf(std::size_t i) const noexcept {
  const auto found = std::ranges::find(acting_, i);
  const auto at = static_cast<std::size_t>(found - acting_.begin());
  return at < solution_.responses().size() ? &solution_.responses()[at] : nullptr;
}

std::vector<Vector3d> TouchedObject::DeformedNodes() const {
  std::vector<Vector3d> p_S;
  if (!body_) return p_S;
  body_->deformation->Displacements(solution_, &p_S);
  for (std::size_t i = 0; i < p_S.size(); ++i) {
    p_S[i] = X_SO_ * Vector3d(body_->surface.nodes[i] + p_S[i]);
  }
  return p_S;
}

}  // namespace palpate
